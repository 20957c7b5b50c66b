import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import from_axis_angle, rotation_matrix
from simsat.learning.appendage.series import (
    build_series,
    fit_inertia,
    inertia_directions,
    joined,
    period_means,
    swing_of,
    unexplained,
)
from simsat.learning.correction.windows import Telemetry
from simsat.mjcf import Model
from tests.appendage_cases import PERIOD, SAMPLE, TICKS, made_up_flights


def test_the_series_is_the_appendages_momentum(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    flights, truth = made_up_flights(craft, 3, 24)
    series = build_series(flights, craft, craft.J, PERIOD)
    scale = np.abs(truth).max()
    # What passes for an external torque is c's own drift; little of it if c is known to swing.
    assert np.abs(series.c - truth[:, ::TICKS]).max() < 0.15 * scale
    wary = build_series(flights, craft, craft.J, PERIOD, swing=scale)
    assert np.abs(wary.c - truth[:, ::TICKS]).max() < 1e-3 * scale
    assert swing_of(wary) == pytest.approx(np.sqrt(np.mean(truth[:, ::TICKS] ** 2)), rel=0.1)


def test_spin_momenta_are_those_that_a_plan_predicts(two_wheel: Model) -> None:
    """Without ramps p' = u: from rest, the mean is p + h u / 2."""
    craft = two_wheel.spacecraft
    flights, _ = made_up_flights(craft, 2, 12)
    series = build_series(flights, craft, craft.J, PERIOD)
    gained = PERIOD * np.cumsum(series.torque, axis=1)
    assert np.abs(series.spin - (gained - 0.5 * PERIOD * series.torque)).max() < 1e-12  # Nms


def test_it_is_linear_in_the_inertia(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    flights, _ = made_up_flights(craft, 2, 12)
    directions = inertia_directions(craft.unactuated)
    d = 0.1 * np.random.default_rng(0).standard_normal(len(directions))
    here = build_series(flights, craft, craft.J, PERIOD)
    there = build_series(flights, craft, craft.J + np.einsum("a,aij->ij", d, directions), PERIOD)
    assert np.abs(here.c + here.c_slope @ d - there.c).max() < 1e-12  # Nms
    assert np.abs(here.mean + here.mean_slope @ d - there.mean).max() < 1e-12
    assert np.abs(there.c - here.c).max() > 1e-3


def test_an_external_torque_is_no_appendage(two_wheel: Model) -> None:
    """A rigid body's momentum under a constant torque in inertial axes leaves no c."""
    random = np.random.default_rng(1)
    t = SAMPLE * np.arange(200.0)
    R = rotation_matrix(from_axis_angle(random.standard_normal((200, 3)), 3.0 * random.random(200)))
    h_N = np.array([0.1, -0.2, 0.05]) + t[:, None] * np.array([1e-3, 2e-3, -1e-3])
    body = np.einsum("kji,kj->ki", R, h_N)
    assert np.abs(unexplained(R, t, body)).max() < 1e-14
    assert np.abs(unexplained(R, t, body + 1e-3 * np.sin(t)[:, None])).max() > 1e-4


def test_least_squares_finds_a_rigid_inertia(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    random = np.random.default_rng(2)
    p = 0.3 * np.cumsum(random.standard_normal((61, craft.wheels)), axis=0) * PERIOD
    p = np.repeat(p - p[0], TICKS, axis=0)
    J_hub = craft.J - (craft.A * craft.Js) @ craft.A.T
    omega = -p @ craft.A.T @ np.linalg.inv(J_hub)
    flight = Telemetry(SAMPLE, omega, p / craft.Js - omega @ craft.A, np.zeros((60, 2)))
    directions = inertia_directions(craft.unactuated)
    d = 0.1 * random.standard_normal(len(directions))
    J_0 = craft.J + np.einsum("a,aij->ij", d, directions)
    found = fit_inertia(build_series([flight], craft, J_0, PERIOD))
    assert np.abs(found + d).max() < 1e-9  # kg m^2


@pytest.mark.parametrize("n", [None, np.array([0.0, 0.0, 1.0]), np.array([0.6, 0.0, 0.8])])
def test_directions_span_what_may_change(n: Array | None) -> None:
    directions = inertia_directions(n)
    flat = directions.reshape(len(directions), 9)
    assert len(directions) == (6 if n is None else 5)
    assert np.abs(flat @ flat.T - np.eye(len(flat))).max() < 1e-14
    assert np.array_equal(directions, np.swapaxes(directions, 1, 2))
    if n is not None:
        assert np.abs(np.einsum("i,aij,j->a", n, directions, n)).max() < 1e-15


def test_period_means_are_exact_for_cubics() -> None:
    t = SAMPLE * np.arange(21.0)
    values = np.stack([1.0 + t - t**2 + 3.0 * t**3, t], axis=-1)
    a, b = 0.0, 0.5
    cubic = (b - a) - 0.0 + (b**2 - a**2) / 2 - (b**3 - a**3) / 3 + 3 * (b**4 - a**4) / 4
    means = period_means(values, TICKS)
    assert means[0, 0] == pytest.approx(cubic / 0.5, rel=1e-13)
    assert means[:, 1] == pytest.approx([0.25, 0.75], rel=1e-13)


def test_joined_keeps_all_flights_in_order(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    flights, _ = made_up_flights(craft, 3, 6)
    whole = build_series(flights, craft, craft.J, PERIOD)
    again = joined([whole.pick(np.array([0])), whole.pick(np.array([1, 2]))])
    assert np.array_equal(again.c, whole.c)
    assert again.flights == 3
