"""A turn by a rotation vector: every form against SciPy, hence against each other."""

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.ground.turn import turned, turned_floats, turned_symbolic

Q = np.array([0.8, -0.36, 0.48, 0.0])
AXIS = np.array([0.48, -0.6, 0.64])


def by_scipy(theta: Array) -> Array:
    before = Rotation.from_quat(attitude.scalar_last(Q))
    return np.asarray((before * Rotation.from_rotvec(theta)).as_matrix())


def symbolic(theta: Array) -> Array:
    return np.array(ca.DM(turned_symbolic(ca.DM(Q), ca.DM(theta)))).ravel()


@pytest.mark.parametrize("angle", [0.0, 1e-13, 1e-6, 0.3, 1.0])
def test_all_forms_are_the_same_turn(angle: float) -> None:
    truth = by_scipy(angle * AXIS)
    forms = (
        turned(Q, angle * AXIS),
        np.array(turned_floats(Q, 0.5 * angle * AXIS)),
        symbolic(angle * AXIS),
    )
    for q, tolerance in zip(forms, (1e-15, 1e-15, 1e-9), strict=True):  # the series: below 1 rad
        assert np.abs(attitude.rotation_matrix(q) - truth).max() < tolerance + 1e-15


@pytest.mark.parametrize("angle", [2.0, np.pi, 6.0])
def test_large_turns_are_exact_where_no_series_is_used(angle: float) -> None:
    truth = by_scipy(angle * AXIS)
    for q in (turned(Q, angle * AXIS), np.array(turned_floats(Q, 0.5 * angle * AXIS))):
        assert np.abs(attitude.rotation_matrix(q) - truth).max() < 2e-15


def test_a_batch_of_turns_is_row_by_row() -> None:
    theta = np.array([0.1, 0.0, -2.0])[:, None] * AXIS
    assert np.array_equal(turned(Q, theta), [turned(Q, one) for one in theta])


def test_the_series_has_a_slope_at_zero() -> None:
    """d/d theta of q (x) exp(theta / 2) at zero is q (x) (0, e_k) / 2."""
    theta = ca.SX.sym("theta", 3)
    slope = ca.Function("slope", [theta], [ca.jacobian(turned_symbolic(ca.DM(Q), theta), theta)])
    columns = [attitude.multiply(Q, np.r_[0.0, e]) / 2.0 for e in np.eye(3)]
    assert np.abs(np.array(slope(np.zeros(3))) - np.stack(columns, axis=-1)).max() < 1e-15
