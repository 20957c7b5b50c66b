"""What every command line here shares: settings from flags, one sentence for bad input."""

import os
import sys
from collections.abc import Callable
from types import FrameType
from typing import TypeVar

import tyro

from simsat.control.ground.errors import SimsatError
from simsat.starting import BROKEN_OFF as BROKEN_OFF
from simsat.starting import take_signals

BAD_INPUT = 2

Settings = TypeVar("Settings")


def parse(
    settings: type[Settings], description: str | None, default: Settings | None = None
) -> Settings:
    """Settings from the command line; --help explains each with its unit and default."""
    if default is None:
        return tyro.cli(settings, description=description)
    return tyro.cli(settings, description=description, default=default)


def command(main: Callable[[], int]) -> int:
    """Run `main`; bad input becomes one sentence on stderr and exit code 2.

    SIGTERM ends a flight as Ctrl-C does: what was flown is written first. A full disk, or output
    that nobody reads on (`| head`), breaks it off with a sentence and exit code 3.
    """
    take_signals(_interrupt)
    try:
        code = main()
        if sys.stdout is not None:
            sys.stdout.flush()  # here, where a failure still gets its sentence
        return code
    except SimsatError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("error: interrupted before there was anything to write", file=sys.stderr)
        return BROKEN_OFF
    except OSError as error:
        _drop_output()
        print(f"error: broken off: {error}", file=sys.stderr)
        return BROKEN_OFF


def _drop_output() -> None:
    """Send what stdout still holds nowhere: Python's own flush at the end would fail again."""
    if sys.stdout is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _interrupt(signum: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt
