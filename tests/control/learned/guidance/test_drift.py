from dataclasses import replace

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import error_angle, from_axis_angle
from simsat.control.learned.estimation.estimate import FIELD, MOMENTUM
from simsat.control.learned.estimation.prior import initial_estimate
from simsat.control.learned.estimation.samples import samples_of
from simsat.control.learned.guidance.drift import (
    arrival_attitude,
    predicted_drift,
    unactuated_error,
)
from simsat.control.learned.guidance.task import BIAS_SHARE
from simsat.control.model.momentum import MomentumModel
from tests.learned_cases import SKEWED, TARGET, TRUE_J, craft, flown, matrix, times

GOAL = from_axis_angle(np.array([1.0, -2.0, 0.5]), 0.8)


@pytest.mark.parametrize("A", [None, SKEWED])
def test_the_drift_is_what_the_full_equations_do(A: Array | None) -> None:
    spacecraft = craft(A=A)
    arm, force = np.array([0.02, 0.01, -0.03]), np.array([2e-5, 4e-5, -3e-5])  # m, N

    def external(t: float, R: Array) -> Array:
        return R @ np.cross(arm, R.T @ force)

    delay, hold = 4.0, 16.0
    f = flown(
        spacecraft,
        lambda t: np.zeros(2),
        np.array([0.0, delay, delay + hold]),
        GOAL,
        np.array([1e-5, -2e-5, 3e-5]),
        external_N=external,
    )
    h_N = matrix(f.q[0]) @ spacecraft.angular_momentum(f.omega[0], f.speed[0])
    model = MomentumModel(spacecraft, TRUE_J, h_N)
    known = initial_estimate(
        spacecraft, samples_of(GOAL, times(1), f.omega[:1], f.speed[:1], spacecraft), 1e-6
    )
    mean = known.mean.copy()
    mean[MOMENTUM] = h_N
    mean[FIELD] = np.r_[np.zeros(6), np.outer(arm, force).ravel()]
    moved = unactuated_error(model, f.q[2], GOAL) - unactuated_error(model, f.q[1], GOAL)
    predicted = predicted_drift(model, replace(known, mean=mean), GOAL, delay, hold)
    assert predicted == pytest.approx(moved, rel=2e-3)
    assert abs(moved) > 1e-4  # rad: something did move


@pytest.mark.parametrize("A", [None, SKEWED])
def test_an_arrival_is_off_by_its_bias_along_n_alone(A: Array | None) -> None:
    model = MomentumModel(craft(A=A), TRUE_J, np.array([0.0, 0.0, 0.0]))
    there = arrival_attitude(model, GOAL, -2e-3)
    assert unactuated_error(model, there, GOAL) == pytest.approx(-2e-3, rel=1e-5)
    assert error_angle(there, GOAL) == pytest.approx(2e-3, rel=1e-5)


def test_the_share_of_the_drift_is_what_the_docstring_says() -> None:
    t = np.linspace(0.0, 1.0, 100_001)

    def rms(share: float, power: int) -> float:
        return float(np.sqrt(np.mean((t**power - share) ** 2)))

    assert rms(BIAS_SHARE, 2) == pytest.approx(rms(0.0, 2), rel=1e-4)
    assert rms(BIAS_SHARE, 2) == pytest.approx(
        np.sqrt(1 / 5 - 2 * BIAS_SHARE / 3 + BIAS_SHARE**2), rel=1e-4
    )
    assert [rms(b, 1) for b in (0.5, BIAS_SHARE, 0.0)] == pytest.approx(
        [0.289, 0.333, 0.577], abs=1e-3
    )
    assert np.sqrt(BIAS_SHARE) == pytest.approx(0.816, abs=1e-3)  # of the hold: the zero crossing


def test_three_wheels_have_nothing_to_bias() -> None:
    spacecraft = craft(A=np.eye(3))
    model = MomentumModel(spacecraft, TRUE_J, np.array([1.0, 1.0, 1.0]))
    samples = samples_of(
        TARGET, times(1), np.array([[0.0, 0.0, 0.0]]), np.zeros((1, 3)), spacecraft
    )
    assert (
        predicted_drift(model, initial_estimate(spacecraft, samples, 1e-6), TARGET, 1.0, 80.0)
        == 0.0
    )
    assert np.all(arrival_attitude(model, GOAL, 0.1) == GOAL)
    assert unactuated_error(model, GOAL, TARGET) == 0.0
