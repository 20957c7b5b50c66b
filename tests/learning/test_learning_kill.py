"""Killed trainings leave no worker behind and come to the same weights."""

import time
from pathlib import Path

import pytest

from tests.bench.kills import require_gone, start
from tests.bench.training_kills import TRAININGS, kill_trainings

FLAGS = ("--flights", "40", "6", "--duration-s", "40", "--workers", "2")

pytestmark = pytest.mark.skipif(
    not Path("/proc").exists(), reason="looks at processes through /proc"
)


def test_no_worker_outlives_a_killed_training(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with start("learning.train", out, *FLAGS) as training:
        while not list(out.glob("flights_1/*.npz")):
            assert training.poll() is None
            time.sleep(0.01)
        training.kill()
    require_gone(training.pid)
    flights = list(out.glob("flights_1/*"))
    assert 0 < len(flights) < 40


@pytest.mark.slow
@pytest.mark.parametrize("module", TRAININGS)
def test_killed_trainings_come_to_the_same_weights(module: str, tmp_path: Path) -> None:
    assert kill_trainings(module, 6, 0, tmp_path).total() == 6
