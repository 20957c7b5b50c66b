"""Signals during a flight: noted first, obeyed at a safe point, restored afterwards."""

import os
import signal

import pytest

from simsat.flight.interrupt import STOPPING, interrupts_noted


@pytest.mark.parametrize("number", STOPPING)
def test_the_first_signal_waits_until_it_is_asked_for(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with interrupts_noted() as stop_if_asked:
        stop_if_asked()  # nothing has come yet
        os.kill(os.getpid(), number)
        with pytest.raises(KeyboardInterrupt):
            stop_if_asked()
    assert signal.getsignal(number) == before


def test_the_second_signal_interrupts_at_once() -> None:
    with interrupts_noted():
        os.kill(os.getpid(), signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGTERM)
