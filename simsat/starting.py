"""What a command does before it imports anything: take signals, and leave out what it never draws.

Called by the package itself; it acts only in a process that was started as `python -m` one of ours.
Importing takes a second, and an exception raised into it by Ctrl-C would end in a traceback, or be
taken for a failure of the library under way: until `command` takes over, either signal ends the
process with one sentence and exit code 3.
"""

import os
import signal
import sys
from collections.abc import Callable
from types import FrameType

BROKEN_OFF = 3
STOPPING = (signal.SIGINT, signal.SIGTERM)
SENTENCE = b"error: interrupted before there was anything to write\n"
NO_WINDOW = {"MUJOCO_GL": "disabled"}  # else MuJoCo starts a process that looks for GLFW: 0.15 s


def begin_command() -> None:
    """Prepare the process and those it starts, if it is a command of ours."""
    if sys.argv[:1] != ["-m"]:  # what runpy puts there while it looks for the module
        return
    for name, value in NO_WINDOW.items():
        os.environ.setdefault(name, value)
    take_signals(_leave)


def take_signals(handler: Callable[[int, FrameType | None], None]) -> None:
    """Let a handler have both signals, but not one that nohup or a background job ignores."""
    for number in STOPPING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _leave(signum: int, frame: FrameType | None) -> None:
    os.write(2, SENTENCE)
    os._exit(BROKEN_OFF)
