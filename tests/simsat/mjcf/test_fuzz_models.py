"""Mutants of the shipped files: each is refused in one message, or flown as it was read."""

import os
import re
import subprocess
import sys

import pytest

from tests.places import ROOT


def fuzzed(first: int, count: int) -> dict[str, int]:
    """Verdicts on so many mutants, by a process that a hang in MuJoCo can't take along."""
    answer = subprocess.run(
        [sys.executable, "-m", "tests.simsat.mjcf.fuzz.run", "--first", f"{first}",
         "--count", f"{count}"],
        cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stdout + answer.stderr[-2000:]
    verdicts = re.findall(r"(\d+) (\w+)", answer.stdout.splitlines()[-1])
    return {verdict: int(number) for number, verdict in verdicts}


def test_a_share_of_mutants_is_refused_or_flown_as_read() -> None:
    verdicts = fuzzed(0, 150)
    assert sum(verdicts.values()) == 150
    assert min(verdicts["accepted"], verdicts["refused"]) > 40  # both are put to the test


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1000, 5000, 500))
def test_thousands_of_mutants_are_refused_or_flown_as_read(first: int) -> None:
    assert sum(fuzzed(first, 500).values()) == 500
