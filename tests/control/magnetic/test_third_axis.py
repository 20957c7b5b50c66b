import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.magnetic.third_axis import (
    DAMPING,
    ThirdAxis,
    expected,
    observed,
    wanted_rate,
    wanted_torque,
)

INERTIA, FREQUENCY, PERIOD, MOST = 1.27, 0.1, 0.5, 6e-6  # kg m^2, rad/s, s, Nm


def flown(angle: float, rate: float, external: float, seconds: float) -> Array:
    """phi_n at every period of a double integrator under the law, its torque held."""
    observer, angles = None, [angle]
    for _ in range(int(seconds / PERIOD)):
        axis = ThirdAxis(angle, rate, INERTIA)
        observer = observed(observer, axis, FREQUENCY, PERIOD)
        asked = wanted_torque(axis, FREQUENCY, observer.external, MOST)
        given = float(np.clip(asked, -MOST, MOST))
        observer = expected(observer, INERTIA, given, PERIOD)
        gained = (given + external) / INERTIA
        angle += PERIOD * rate + 0.5 * PERIOD**2 * gained
        rate += PERIOD * gained
        angles.append(angle)
    return np.array(angles)


def test_near_zero_it_is_the_pd_it_says() -> None:
    step = 1e-6
    axis, moved = ThirdAxis(0.0, 0.0, INERTIA), ThirdAxis(step, 0.0, INERTIA)
    turning = ThirdAxis(0.0, step, INERTIA)
    at = wanted_torque(axis, FREQUENCY, 2e-7, MOST)
    assert at == -2e-7
    stiffness = (wanted_torque(moved, FREQUENCY, 2e-7, MOST) - at) / step
    damping = (wanted_torque(turning, FREQUENCY, 2e-7, MOST) - at) / step
    assert stiffness == pytest.approx(-INERTIA * FREQUENCY**2)
    assert damping == pytest.approx(-INERTIA * 2.0 * DAMPING * FREQUENCY)


def test_the_rate_wanted_can_be_stopped_with_the_deceleration_given() -> None:
    braking, angles = 2e-6, np.geomspace(1e-6, 1.0, 400)
    rates = np.array([wanted_rate(angle, FREQUENCY, braking) for angle in angles])
    needed = np.gradient(0.5 * rates**2, angles)  # w dw/dphi
    assert np.all(needed <= braking * (1.0 + 1e-3))
    assert np.all(np.diff(np.abs(rates)) > 0.0)
    assert wanted_rate(-0.3, FREQUENCY, braking) == -wanted_rate(0.3, FREQUENCY, braking)


@pytest.mark.parametrize("degrees", [0.001, 0.1, 2.0])
@pytest.mark.parametrize("external", [0.0, 2e-6, -4e-6])
def test_it_comes_home_within_the_rods_limit_whatever_acts(degrees: float, external: float) -> None:
    start = float(np.deg2rad(degrees))
    angles = flown(start, 0.0, external, 2000.0)
    assert np.abs(angles[-200:]).max() < 1e-7
    # Until it is learned (two time constants), what nobody told of pushes the craft aside.
    pushed = 0.5 * abs(external) / INERTIA * (2.0 / FREQUENCY) ** 2
    assert -angles.min() < 0.05 * start + pushed


@pytest.mark.parametrize("external", [3e-6, -4e-6])
def test_the_torque_from_outside_is_learned_also_at_the_rods_limit(external: float) -> None:
    rate, observer = 0.0, None
    for _ in range(200):
        observer = observed(observer, ThirdAxis(1.0, rate, INERTIA), FREQUENCY, PERIOD)
        observer = expected(observer, INERTIA, -MOST, PERIOD)
        rate += PERIOD * (external - MOST) / INERTIA
    assert observer is not None
    assert observer.external == pytest.approx(external, rel=1e-3)
