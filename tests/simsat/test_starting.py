"""Interrupted before it has begun: one sentence, exit code 3, whatever was being imported."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.places import ROOT

SLOW_LIBRARY = """
import os, signal
try:
    os.kill(os.getpid(), signal.SIGNUMBER)
    for _ in range(10_000_000):
        pass
except BaseException:  # as libraries do around imports that may fail
    pass
"""


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    "command", ["simsat.run", "simsat.campaign", "simsat.replay", "simsat.verify", "learning.train"]
)
@pytest.mark.parametrize("library", ["numpy", "tyro"])
def test_a_signal_while_a_library_is_imported(
    tmp_path: Path, command: str, stop: signal.Signals, library: str
) -> None:
    """The library sends the signal itself: nothing is left to chance."""
    (tmp_path / f"{library}.py").write_text(SLOW_LIBRARY.replace("SIGNUMBER", stop.name))
    answer = subprocess.run(
        [sys.executable, "-m", command, "--help"],
        cwd=ROOT, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert answer.returncode == 3
    assert answer.stderr == "error: interrupted before there was anything to write\n"
    assert answer.stdout == ""


def test_importing_the_package_leaves_signals_and_environment_alone() -> None:
    script = (
        "import signal, os; before = signal.getsignal(signal.SIGINT), dict(os.environ)\n"
        "import simsat.settings\n"
        "assert (signal.getsignal(signal.SIGINT), dict(os.environ)) == before"
    )
    subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True)
