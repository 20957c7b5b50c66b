"""Spacecraft of the benchmark's size reach the target from 75 and 125 degrees, by the baseline."""

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from simsat.flight.mission import prepare
from simsat.mjcf.shipped import MODELS
from simsat.results.metrics import judge
from simsat.settings import FlightSettings

SLOW_PHYSICS = "two_wheel_imbalance"  # 200,000 steps a flight: once is enough
BENCHMARK_SIZED = (
    "flexible_panels", "pyramid", "slosh", "three_wheel", "two_wheel", "two_wheel_friction",
    "two_wheel_skewed",
)  # fmt: skip


def fly(model: Path, angle_deg: float) -> dict[str, Any]:
    mission = prepare(FlightSettings(model=model, angle_deg=angle_deg))
    return judge(mission.fly(), mission.target)


@pytest.mark.parametrize(
    ("name", "angle_deg"),
    [(name, angle) for name in BENCHMARK_SIZED for angle in (75.0, 125.0)] + [(SLOW_PHYSICS, 75.0)],
)
def test_the_target_is_reached(name: str, angle_deg: float) -> None:
    metrics = fly(Path(name), angle_deg)
    assert metrics["converged"], metrics
    assert metrics["solver_failures"] == 0
    assert not any(metrics["limit_violations"].values())


@pytest.mark.parametrize("name", ["three_wheel", "pyramid"])
def test_fully_actuated_ones_simply_do_better(name: str) -> None:
    full, two = fly(Path(name), 125.0), fly(Path("two_wheel"), 125.0)
    assert full["settling_time_s"] < 0.5 * two["settling_time_s"]
    assert full["final_error_deg"] < 0.1 * two["final_error_deg"]


@pytest.mark.parametrize("failed", [1, 2])
def test_a_pyramid_that_lost_wheels_still_arrives(tmp_path: Path, failed: int) -> None:
    """With three wheels as before; with two as an underactuated spacecraft does."""
    shutil.copytree(MODELS, tmp_path / "models")
    path = tmp_path / "models" / "pyramid" / "pyramid.xml"
    for wheel in range(2, 2 + failed):
        path.write_text(re.sub(rf".*motor_{wheel}.*\n", "", path.read_text()))
    metrics = fly(path, 75.0)
    assert metrics["converged"], metrics
