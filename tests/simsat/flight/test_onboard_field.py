"""What the craft knows of the magnetic field: models on board, and a magnetometer beside rods."""

from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.ground import attitude
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.measurement import Measurement
from simsat.control.interface.plan import Plan
from simsat.environment import OrbitSettings
from simsat.environment.fields.dipole import dipole_field
from simsat.environment.fields.igrf import igrf_field
from simsat.environment.orbit import circular_orbit

DIPOLE = np.array([0.1, -0.05, 0.02])


class Noting:
    """A controller that notes what it is told and commands some dipole in some periods."""

    def __init__(self, dipole: Any, every: int = 1):
        self.heard: list[Measurement] = []
        self._dipole, self._every = dipole, every

    def __call__(self, brief: Any) -> Any:
        self.brief = brief
        return self.law

    def law(self, now: Measurement) -> Plan:
        self.heard.append(now)
        on = len(self.heard) % self._every == 0
        return Plan(np.zeros(2), dipole=self._dipole if on else None)


def flown(dipole: Any = None, every: int = 1, **settings: Any) -> tuple[Noting, Any]:
    noting = Noting(dipole, every)
    result = simsat.fly("two_wheel_rods", controller=noting, duration_s=20.0, **settings)
    assert result.flight.ending.name == "COMPLETE", result.flight.reason
    return noting, result


def true_fields(noting: Noting, result: Any, delay: int = 0) -> np.ndarray:
    plant = result.flight.plant
    rows = np.maximum(np.arange(len(noting.heard)) * 10 - delay, 0)
    to_body = np.swapaxes(attitude.rotation_matrix(plant.attitudes[rows]), 1, 2)
    B = result.mission.environment.field_N(rows * plant.tick)
    return np.einsum("kij,kj->ki", to_body, B)


def test_by_default_the_model_on_board_is_the_one_that_is_flown() -> None:
    noting, result = flown(environment={"field": "igrf"}, start={"omega_deg_s": (1.0, 0.5, -0.3)})
    known = np.array([now.field_B for now in noting.heard])
    np.testing.assert_allclose(known, true_fields(noting, result), atol=1e-18)


@pytest.mark.parametrize(("name", "model"), [("igrf", igrf_field), ("dipole", dipole_field)])
def test_another_model_on_board_is_asked_whatever_flies(name: str, model: Any) -> None:
    other = "dipole" if name == "igrf" else "igrf"
    noting, _ = flown(environment={"field": other}, onboard={"field": name})
    now = noting.heard[-1]
    B_N = np.array(model(circular_orbit(OrbitSettings()))(now.t))
    expected = attitude.rotation_matrix(now.q).T @ B_N
    assert now.field_B is not None
    np.testing.assert_allclose(now.field_B, expected, atol=1e-18)


def test_a_model_turns_with_the_attitude_as_it_is_sensed() -> None:
    noting, result = flown(sensors={"enabled": True, "attitude_noise_arcsec": 3600.0})
    known = np.array([now.field_B for now in noting.heard])
    off = np.linalg.norm(known - true_fields(noting, result), axis=1)
    assert 1e-8 < off.mean() < 3e-6  # T: a degree of 4e-5


def test_a_magnetometer_reads_the_field_and_its_own_errors() -> None:
    exact, result = flown(onboard={"field": "magnetometer"}, start={"omega_deg_s": (1.0, 0.5, 0.0)})
    known = np.array([now.field_B for now in exact.heard])
    np.testing.assert_allclose(known, true_fields(exact, result), atol=1e-18)
    sensors = {"enabled": True, "magnetometer_noise_nT": 50.0, "magnetometer_bias_nT": 300.0}
    errors = []
    for seed in (3, 3, 4):
        noting, result = flown(onboard={"field": "magnetometer"}, sensors={**sensors, "seed": seed})
        known = np.array([now.field_B for now in noting.heard])
        errors.append(1e9 * (known - true_fields(noting, result, delay=1)))
    np.testing.assert_array_equal(errors[0], errors[1])  # the same seed, the same errors
    assert not np.allclose(errors[0], errors[2])
    assert errors[0].std(axis=0).mean() == pytest.approx(50.0, rel=0.25)  # nT; 120 draws
    bias = np.abs([error.mean(axis=0) for error in errors]).mean()
    assert 80.0 < bias < 700.0  # nT


def test_a_magnetometer_is_blind_while_rods_are_on() -> None:
    always = {"field": "magnetometer", "quiet_samples": 0}
    noting, _ = flown(DIPOLE, every=2, onboard=always)
    seen = [now.field_B is not None for now in noting.heard]
    assert seen[0]  # nothing has been commanded yet
    assert seen[2::2] == [False] * 19  # after the periods with rods
    assert all(seen[1::2])


def test_resting_rods_let_it_see_and_give_the_dipole_in_the_mean() -> None:
    noting, result = flown(DIPOLE, onboard={"field": "magnetometer", "quiet_samples": 2})
    assert all(now.field_B is not None for now in noting.heard)
    dipoles = result.flight.plant.dipoles[1:].reshape(40, 10, 3)
    np.testing.assert_allclose(dipoles.mean(axis=1), np.tile(DIPOLE, (40, 1)), rtol=1e-12)
    assert not dipoles[:, 8:].any()
    np.testing.assert_array_equal(noting.heard[5].dipole, DIPOLE)
    np.testing.assert_allclose(noting.brief.nominal.rods.dipole_max, 0.8 * 0.2)
    strong, result = flown([1.0, 1.0, 1.0], onboard={"field": "magnetometer"})
    assert np.abs(result.flight.plant.dipoles).max() == pytest.approx(0.2)
    np.testing.assert_allclose(strong.heard[-1].dipole, 0.16)


def test_rods_that_would_never_be_on_are_refused() -> None:
    with pytest.raises(SettingsError, match=r"--onboard\.quiet-samples is 10: a control period"):
        simsat.prepare_mission(
            "two_wheel_rods", onboard={"field": "magnetometer", "quiet_samples": 10}
        )
