from collections.abc import Sequence

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import error_angle, from_axis_angle
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.guidance.minimum_time import (
    BoundaryValues,
    MinimumTimeSlew,
    build_minimum_time,
    solve_minimum_time,
)
from simsat.control.model.momentum import MomentumModel
from tests.learned_cases import JS, TARGET, TRUE_J, craft, flown

LIMIT = 0.05


def shortest(
    spacecraft: Spacecraft,
    J: Array,
    axis: Sequence[float],
    angle_deg: float,
    intervals: int = 20,
    guess: int = 0,
) -> MinimumTimeSlew:
    m = spacecraft.wheels
    q = from_axis_angle(np.array(axis, float), np.deg2rad(angle_deg))
    model = MomentumModel(spacecraft, J, np.array([0.0, 0.0, 0.0]))
    problem = build_minimum_time(spacecraft, intervals)
    values = BoundaryValues(q, np.zeros(m), TARGET, np.full(m, LIMIT))
    found = solve_minimum_time(problem, model, values, guess)
    assert found is not None
    return found


def test_a_small_turn_about_one_wheel_takes_the_double_integrators_time() -> None:
    J = np.diag([1.5, 1.5, 1.2])
    found = shortest(craft(J), J, (1, 0, 0), 5.0)
    bang_bang = 2.0 * np.sqrt(np.deg2rad(5.0) * (1.5 - JS) / LIMIT)
    assert found.duration == pytest.approx(bang_bang, rel=2e-3)


def test_half_a_turn_of_a_sphere_takes_the_published_time() -> None:
    # Bilimoria and Wie, J. Guidance 16(3), 1993: 3.2430 sqrt(J/u) against 3.5449 about the axis.
    J = 1.5 * np.eye(3)
    hub = J - JS * np.eye(3)
    found = shortest(craft(J, np.eye(3)), J, (0, 0, 1), 180.0, intervals=40, guess=2)
    assert found.duration / np.sqrt(hub[0, 0] / LIMIT) == pytest.approx(3.2430, rel=3e-3)


def test_two_wheels_turn_about_the_axis_they_do_not_have() -> None:
    spacecraft = craft()
    found = shortest(spacecraft, TRUE_J, (0, 0, 1), 75.0, intervals=60, guess=1)
    step = found.duration / 60.0
    t = np.array([0.0, found.duration])
    q0 = from_axis_angle(np.array([0.0, 0.0, 1.0]), np.deg2rad(75.0))
    f = flown(spacecraft, lambda time: found.torque[min(int(time / step), 59)], t, q0, rtol=1e-6)
    assert error_angle(f.q[-1], TARGET) < 0.01  # rad: SciPy meets 60 jumps of the torque
    assert np.max(np.abs(f.omega[-1])) < 0.005
    assert 20.0 < found.duration < 30.0


def test_the_speed_limit_of_a_wheel_is_kept() -> None:
    slow = craft(speed_max=60.0)
    free, kept = (shortest(c, TRUE_J, (1, 0.3, 0.1), 90.0) for c in (craft(), slow))
    impulse = np.cumsum(kept.torque, axis=0) * kept.duration / 20.0
    assert np.max(np.abs(impulse)) <= 0.97 * JS * 60.0 * (1 + 1e-6)
    assert kept.duration > 1.2 * free.duration


def test_the_same_guess_gives_the_same_slew() -> None:
    one, two = (shortest(craft(), TRUE_J, (1, 2, 3), 75.0, guess=3) for _ in range(2))
    assert np.array_equal(one.torque, two.torque)


def test_on_the_control_grid_the_impulse_is_kept() -> None:
    torque = np.random.default_rng(0).normal(size=(20, 2))
    slew = MinimumTimeSlew(9.3, torque, 1)
    grid = slew.on_grid(20, 0.5)
    assert np.sum(grid, axis=0) * 0.5 == pytest.approx(np.sum(torque, axis=0) * 9.3 / 20)
