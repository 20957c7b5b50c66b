"""The closed forms of the torque ramp against a numerical integral of the ramp itself."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, trapezoid

from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.ramp import (
    mean_ramped_torque,
    ramped_impulse,
    ramped_spin,
    ramped_torques,
    reached_torque,
)
from tests.learned_cases import craft, ramped

PERIOD = 0.5  # s
TWO = craft()  # 0.4 Nm/s
BEFORE = np.array([-0.05, 0.02])
AFTER = [np.array([0.05, 0.019]), np.array([-0.05, 0.02]), np.array([0.1, -0.13])]
TOO_FAR = np.array([0.3, -0.4])  # ramps of 0.9 and 1.05 s
P = np.array([0.1, -0.3])  # Nms


def integrals(after: Array) -> tuple[Array, Array]:
    """Impulse, Nms, and mean of p over the period: trapezia between the corners of the ramp."""
    corners = np.minimum(np.abs(after - BEFORE) / TWO.torque_rate_max, PERIOD)
    t = np.union1d(np.linspace(0.0, PERIOD, 20_001), corners)
    torque = ramped(after[None], BEFORE, 0.4, PERIOD)
    u = np.array([torque(min(time, PERIOD - 1e-12)) for time in t])
    path = P + cumulative_trapezoid(u, t, axis=0, initial=0.0)
    return path[-1] - P, trapezoid(path, t, axis=0) / PERIOD


def spin(spacecraft: Spacecraft, after: Array) -> list[Array]:
    """Torque reached, momentum then, and its mean, of the symbolic form."""
    rate = ca.DM(spacecraft.torque_rate_max)
    parts = ramped_spin(ca.DM(P), ca.DM(after), ca.DM(BEFORE), PERIOD, rate)
    return [np.array(part).ravel() for part in parts]


@pytest.mark.parametrize("after", AFTER)
def test_every_form_is_the_ramps_integral(after: Array) -> None:
    impulse, mean_p = integrals(after)
    rate = TWO.torque_rate_max
    assert np.abs(ramped_impulse(after, BEFORE, rate, PERIOD) - impulse).max() < 1e-12  # Nms
    steps = ramped_torques(after, BEFORE, rate, PERIOD)
    assert np.abs(steps.sum(axis=0) * PERIOD / len(steps) - impulse).max() < 1e-12
    smooth = np.array(mean_ramped_torque(TWO, ca.DM(after), ca.DM(BEFORE), PERIOD)).ravel()
    assert np.abs(smooth * PERIOD - impulse).max() < 3e-8  # its rounding near zero
    _, p, mean = spin(TWO, after)
    assert np.abs(p - P - impulse).max() < 1e-12
    assert np.abs(mean - mean_p).max() < 1e-9


def test_a_ramp_longer_than_the_period_is_cut() -> None:
    impulse, mean_p = integrals(TOO_FAR)
    assert (
        np.abs(ramped_impulse(TOO_FAR, BEFORE, TWO.torque_rate_max, PERIOD) - impulse).max() < 1e-12
    )
    reached, p, mean = spin(TWO, TOO_FAR)
    assert np.abs(reached - BEFORE - np.array([0.2, -0.2])).max() < 1e-15  # Nm
    assert np.array_equal(reached, reached_torque(TOO_FAR, BEFORE, TWO.torque_rate_max, PERIOD))
    assert np.abs(p - P - impulse).max() < 1e-12
    assert np.abs(mean - mean_p).max() < 1e-9


def test_without_a_rate_limit_there_is_no_ramp() -> None:
    free = replace(TWO, torque_rate_max=np.full(2, np.inf))
    step = PERIOD * AFTER[0]
    assert np.array_equal(ramped_impulse(AFTER[0], BEFORE, free.torque_rate_max, PERIOD), step)
    reached, p, _ = spin(free, AFTER[0])
    assert np.array_equal(reached, AFTER[0])
    assert np.abs(p - P - step).max() < 1e-15
