"""What every command line here shares: settings from flags, one sentence for bad input."""

import signal
import sys
from collections.abc import Callable
from types import FrameType
from typing import TypeVar

import tyro

from simsat.errors import SimsatError

BAD_INPUT = 2
BROKEN_OFF = 3

Settings = TypeVar("Settings")


def parse(settings: type[Settings], description: str | None) -> Settings:
    """Settings from the command line; --help explains each with its unit and default."""
    return tyro.cli(settings, description=description)


def command(main: Callable[[], int]) -> int:
    """Run `main`; bad input becomes one sentence on stderr and exit code 2.

    SIGTERM ends a flight as Ctrl-C does: what was flown is written first.
    """
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        return main()
    except SimsatError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("error: interrupted before there was anything to write", file=sys.stderr)
        return BROKEN_OFF


def _interrupt(signum: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt
