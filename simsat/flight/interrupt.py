"""Ctrl-C and SIGTERM during a flight, taken between control periods.

An interrupt raised wherever the interpreter happens to be may land inside a library that drops it
(the recorder's writer does), and the flight would go on. So the first signal is only noted, and the
flight asks after every period; a second one interrupts at once.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

STOPPING = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interrupts_noted() -> Iterator[Callable[[], None]]:
    """Inside the block the value raises KeyboardInterrupt if a signal has come since."""
    asked = False

    def note(signum: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    def stop_if_asked() -> None:
        if asked:
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield stop_if_asked  # only the main thread may set handlers
        return
    before = {number: signal.signal(number, note) for number in STOPPING}
    try:
        yield stop_if_asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
