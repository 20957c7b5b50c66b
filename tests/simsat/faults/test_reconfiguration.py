"""Wheels that fail in flight: noticed within two seconds, flown without, and never for nothing."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.ground.errors import SettingsError
from simsat.flight.mission import prepare
from simsat.settings import FlightSettings


def flown(model: str, *faults: str, **settings: Any) -> Any:
    chosen: dict[str, Any] = {"controller": "nmpc-learned", "duration_s": 40.0, **settings}
    return simsat.fly(model, fault=faults, reconfigure=True, **chosen)


def noticed(result: Any) -> float | None:
    failed = result.steps["plan_wheels_failed"].to_numpy()
    return float(result.steps["t_s"].to_numpy()[failed > 0][0]) if failed.any() else None


@pytest.mark.parametrize("kind", ["seize", "dead"])
def test_a_pyramid_goes_on_with_three(kind: str) -> None:
    result = flown("pyramid", f"wheel_2:{kind}@4")
    at = noticed(result)
    assert at is not None
    assert 4.0 < at <= 6.0
    assert result.converged
    alone = simsat.fly("pyramid", controller="nmpc-learned", duration_s=40.0,
                       fault=(f"wheel_2:{kind}@4",))  # fmt: skip
    slower = alone.metrics["settling_time_s"]
    assert slower is None or slower > result.metrics["settling_time_s"]
    torque = result.flight.plant.torques[round(at / 0.05) + 10 :, 1]
    assert np.abs(torque).max() < 1e-15  # Nm


def test_a_fully_actuated_craft_becomes_an_underactuated_one() -> None:
    result = flown("three_wheel", "wheel_z:seize@4", duration_s=60.0)
    at = noticed(result)
    assert at is not None
    assert at <= 6.0
    assert result.converged


@pytest.mark.slow
def test_two_failures_of_a_pyramid() -> None:
    result = flown("pyramid", "wheel_2:seize@4", "wheel_4:seize@9", duration_s=60.0)
    failed = result.steps["plan_wheels_failed"].to_numpy()
    assert failed[-1] == 2.0
    assert result.converged


@pytest.mark.slow
def test_the_nmpc_goes_on_too() -> None:
    result = flown("pyramid", "wheel_2:dead@4", controller="nmpc", duration_s=20.0)
    assert noticed(result) is not None
    assert np.isfinite(result.flight.plant.rates).all()


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["cubesat", "smallsat", "highend"])
def test_a_sound_craft_keeps_its_wheels(preset: str) -> None:
    for friction in ((), ("wheel_1:friction=0.01@0", "wheel_3:friction=0.01@0")):
        result = flown("pyramid", *friction, sensors={"preset": preset}, duration_s=25.0)
        assert noticed(result) is None


def test_a_sound_flight_is_the_same_to_the_last_bit() -> None:
    plain = simsat.fly("three_wheel", controller="nmpc-learned", duration_s=15.0)
    watched = flown("three_wheel", duration_s=15.0)
    np.testing.assert_array_equal(plain.flight.plant.attitudes, watched.flight.plant.attitudes)


def test_a_controller_that_cant_do_with_fewer_wheels_is_named() -> None:
    with pytest.raises(
        SettingsError, match=r"--reconfigure needs a controller .* 'nmpc-pinn' can't"
    ):
        prepare(FlightSettings(model=Path("two_wheel"), controller="nmpc-pinn", reconfigure=True))
