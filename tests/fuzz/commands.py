"""Commands called in this process with what no user should type, and what must come of it.

Bad input ends with exit code 2 and either one line on stderr or tyro's box; good input would be
flown, which is left out here: everything up to the first period is done.
"""

import contextlib
import io
import resource
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import simsat.bad_network_study
import simsat.campaign.command
import simsat.command
import simsat.control.nmpc.planner
import simsat.new
import simsat.replay
import simsat.run
import simsat.verify
from simsat.command import BAD_INPUT, command

MAINS: dict[str, Callable[[], int]] = {
    "run": lambda: simsat.run.main(),
    "new": lambda: simsat.new.main(),
    "replay": lambda: simsat.replay.main(),
    "campaign": lambda: simsat.campaign.command.main(),
    "verify": lambda: simsat.verify.main(),
    "bad_network_study": lambda: simsat.bad_network_study.main(),
}


MEMORY = 2_000_000_000  # bytes


class FlyableError(Exception):
    """Raised in the place of a flight: the input was accepted."""


@dataclass(frozen=True)
class Outcome:
    """How a command ended."""

    code: int
    err: str

    @property
    def kind(self) -> str:
        """accepted, sentence or box; anything else fails the test."""
        if self.code == 0:
            return "accepted"
        assert self.code == BAD_INPUT, f"exit code {self.code}: {self.err}"
        if self.err.lstrip().startswith("╭─"):
            return "box"
        lines = self.err.splitlines()
        assert len(lines) == 1, f"not one line: {self.err!r}"
        assert lines[0].startswith("error: ")
        assert lines[0].isprintable()
        assert len(lines[0]) < 2000
        return "sentence"


@pytest.fixture
def nothing_flies(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Commands stop where they would write their folder; solvers aren't compiled, and what fills
    the memory is told so before the machine is."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    used = resource.getpagesize() * int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, before[1]))

    def flyable(*args: Any, **options: Any) -> Any:
        raise FlyableError

    monkeypatch.setattr(simsat.run, "fly_into", flyable)
    monkeypatch.setattr(simsat.replay, "fly_into", flyable)
    monkeypatch.setattr(simsat.campaign.command, "open_folder", flyable)
    monkeypatch.setattr(simsat.bad_network_study, "make_folder", flyable)
    monkeypatch.setattr(simsat.command, "_drop_output", lambda: None)
    monkeypatch.setattr(simsat.control.nmpc.planner, "solver_of", lambda *args: None)
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)
    for name in [name for name in sys.modules if name.startswith("fuzzed_")]:
        del sys.modules[name]


def call(name: str, words: Sequence[str]) -> Outcome:
    """The command's outcome; an exception that it doesn't turn into a sentence is raised."""
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", "backslashreplace") for _ in range(2))
    before = sys.argv
    sys.argv = [f"simsat {name}", *words]
    try:
        with contextlib.redirect_stderr(err), contextlib.redirect_stdout(out):
            code = command(MAINS[name])
    except FlyableError:
        code = 0
    except SystemExit as end:  # tyro's: help or its box
        code = end.code if isinstance(end.code, int) else 1
    finally:
        sys.argv = before
    err.seek(0)
    return Outcome(code, err.read())
