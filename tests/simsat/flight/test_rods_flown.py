"""Two wheels and three rods in closed loop, on the plant."""

from typing import Any

import numpy as np
import pytest

import simsat
from simsat.results.flight_result import FlightResult


def flown(**settings: Any) -> FlightResult:
    choices: dict[str, Any] = {
        "duration_s": 120.0,
        "environment.magnetic": True,
        "axis": (0.3, -0.5, 0.81),
    }
    return simsat.fly("two_wheel_rods", **(choices | settings))


@pytest.mark.parametrize("controller", ["nmpc-learned", "nmpc"])
def test_rods_hold_the_axis_that_wheels_cannot(controller: str) -> None:
    with_rods = flown(controller=controller, angle_deg=75.0)
    without = flown(controller=controller, angle_deg=75.0, **{"rods.enabled": False})
    assert not np.any(without.table["dipole_rod_x"].to_numpy())
    assert np.abs(with_rods.table["dipole_rod_x"].to_numpy()).max() <= 0.2
    assert with_rods.metrics["final_error_deg"] < 0.5 * without.metrics["final_error_deg"]


def test_the_learned_controller_with_rods_ends_below_a_thousandth_of_a_degree() -> None:
    assert flown(controller="nmpc-learned", angle_deg=125.0).metrics["final_error_deg"] < 1e-3


def test_the_learned_controller_follows_nadir() -> None:
    """Arriving where the reference was, or at rest, would miss by its turn of 0.06 deg/s."""
    flight = flown(controller="nmpc-learned", angle_deg=75.0, **{"reference.to": ("nadir",)})
    assert flight.metrics["settling_time_s"] < 25.0
    assert flight.metrics["final_error_deg"] < 2e-3
