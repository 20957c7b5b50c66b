"""The closed forms of the torque ramp against a numerical integral of the ramp itself."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, trapezoid

from simsat.control.ground.arrays import Array
from simsat.control.model.ramp import (
    mean_ramped_torque,
    ramped_impulse,
    ramped_spin,
    ramped_torques,
)
from tests.learned_cases import craft, ramped

PERIOD = 0.5  # s
TWO = craft()  # 0.4 Nm/s
BEFORE = np.array([-0.05, 0.02])
AFTER = [np.array([0.05, 0.019]), np.array([-0.05, 0.02]), np.array([0.1, -0.13])]
P = np.array([0.1, -0.3])  # Nms


def integrals(after: Array) -> tuple[Array, Array]:
    """Impulse, Nms, and mean of p over the period: trapezia between the corners of the ramp."""
    corners = np.abs(after - BEFORE) / TWO.torque_rate_max
    t = np.union1d(np.linspace(0.0, PERIOD, 20_001), corners)
    torque = ramped(after[None], BEFORE, 0.4, PERIOD)
    u = np.array([torque(min(time, PERIOD - 1e-12)) for time in t])
    path = P + cumulative_trapezoid(u, t, axis=0, initial=0.0)
    return path[-1] - P, trapezoid(path, t, axis=0) / PERIOD


@pytest.mark.parametrize("after", AFTER)
def test_every_form_is_the_ramps_integral(after: Array) -> None:
    impulse, mean_p = integrals(after)
    rate = TWO.torque_rate_max
    assert np.abs(ramped_impulse(after, BEFORE, rate, PERIOD) - impulse).max() < 1e-12  # Nms
    steps = ramped_torques(after, BEFORE, rate, PERIOD)
    assert np.abs(steps.sum(axis=0) * PERIOD / len(steps) - impulse).max() < 1e-12
    smooth = np.array(mean_ramped_torque(TWO, ca.DM(after), ca.DM(BEFORE), PERIOD)).ravel()
    assert np.abs(smooth * PERIOD - impulse).max() < 3e-8  # its rounding near zero
    p, mean = (np.array(x).ravel() for x in ramped_spin(TWO, ca.DM(P), after, BEFORE, PERIOD))
    assert np.abs(p - P - impulse).max() < 1e-12
    assert np.abs(mean - mean_p).max() < 1e-9


def test_no_time_changes_no_momentum() -> None:
    for part in ramped_spin(TWO, ca.DM(P), AFTER[0], BEFORE, 0.0):
        assert np.array_equal(np.array(part).ravel(), P)


def test_without_a_rate_limit_there_is_no_ramp() -> None:
    free = replace(TWO, torque_rate_max=np.full(2, np.inf))
    step = PERIOD * AFTER[0]
    assert np.array_equal(ramped_impulse(AFTER[0], BEFORE, free.torque_rate_max, PERIOD), step)
    p, _ = ramped_spin(free, ca.DM(P), AFTER[0], BEFORE, PERIOD)
    assert np.abs(np.array(p).ravel() - P - step).max() < 1e-15
