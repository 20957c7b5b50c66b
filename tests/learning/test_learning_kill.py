"""A training killed during its parallel flights leaves no worker behind."""

import time
from pathlib import Path

import pytest

from tests.bench.kills import require_gone, start

FLAGS = ("--flights", "40", "6", "--duration-s", "40", "--workers", "2")


@pytest.mark.skipif(not Path("/proc").exists(), reason="looks at processes through /proc")
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
