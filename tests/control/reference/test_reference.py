"""References over time: attitude and rate belong together, whatever the curve."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.reference.reference import Curve, Inertial, Sequence, Times


def numerical_rate(reference: Curve, t: Array, h: float = 1e-3) -> Array:
    before, after = reference.attitude(t - h), reference.attitude(t + h)
    turn = attitude.multiply(attitude.conjugate(before), after)
    return attitude.rotation_vector(turn) / (2.0 * h)


def test_the_rate_of_a_curve_is_its_derivative() -> None:
    rng = np.random.default_rng(4)
    spline = CubicSpline(
        np.arange(30.0),
        attitude.continuous(
            attitude.normalized(np.cumsum(0.2 * rng.standard_normal((30, 4)), axis=0) + 0.7)
        ),
    )
    scaled = Curve(lambda t: 3.0 * spline(t), lambda t: 3.0 * spline(t, 1))
    t = np.linspace(1.0, 28.0, 57)
    rate = scaled.rate(t)
    assert np.linalg.norm(rate, axis=1).max() > 0.1  # rad/s
    np.testing.assert_allclose(rate, numerical_rate(scaled, t), atol=1e-5)
    one = np.array([scaled.rate(float(s)) for s in t])
    np.testing.assert_allclose(one, rate, atol=1e-14)


def test_a_steady_turn_about_a_body_axis_has_that_rate_in_its_own_axes() -> None:
    start, axis, speed = np.array([0.5, 0.5, -0.5, 0.5]), np.array([0.6, 0.0, 0.8]), 0.3

    def at(t: Times, order: int = 0) -> Array:
        half = 0.5 * speed * np.asarray(t)[..., None]
        parts = (np.cos(half), np.sin(half) * axis)
        if order:
            parts = (-0.5 * speed * np.sin(half), 0.5 * speed * np.cos(half) * axis)
        return attitude.multiply(start, np.concatenate(parts, axis=-1))

    turning = Curve(at, lambda t: at(t, 1))
    assert turning.moving
    t = np.array([0.0, 3.0, 50.0])
    np.testing.assert_allclose(turning.rate(t), np.tile(speed * axis, (3, 1)), atol=1e-14)


def test_one_attitude_stays_and_does_not_turn() -> None:
    q = attitude.normalized(np.array([0.3, 0.2, -0.5, 0.7]))
    still = Inertial(q)
    assert not still.moving
    np.testing.assert_array_equal(still.attitude(17.0), q)
    np.testing.assert_array_equal(still.attitude(np.arange(3.0)), [q, q, q])
    np.testing.assert_array_equal(still.rate(np.arange(3.0)), np.zeros((3, 3)))
    assert still.rate(1.0).shape == (3,)


def test_a_sequence_counts_from_its_starts_on() -> None:
    q = np.eye(4)[:3]
    sequence = Sequence(np.array([0.0, 10.0, 30.0]), q)
    assert sequence.moving
    assert not Sequence(np.array([0.0]), q[:1]).moving
    np.testing.assert_array_equal(sequence.index(np.array([-1.0, 0.0, 9.99, 10.0, 99.0])),
                                  [0, 0, 0, 1, 2])  # fmt: skip
    np.testing.assert_array_equal(sequence.attitude(np.array([0.0, 10.0])), q[:2])
    np.testing.assert_array_equal(sequence.attitude(29.9), q[1])
    assert not sequence.rate(np.arange(3.0)).any()


@pytest.mark.parametrize("t", [0.0, 1.0])
def test_shapes_of_one_instant(t: float) -> None:
    assert Inertial(np.eye(4)[0]).attitude(t).shape == (4,)
    assert Sequence(np.array([0.0]), np.eye(4)[:1]).rate(t).shape == (3,)
