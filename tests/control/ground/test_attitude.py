"""Quaternion algebra against SciPy's rotations, near identity, generic and near half a turn."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from simsat.control.ground import attitude

ANGLES = [1e-9, 1e-4, 0.3, 2.0, np.pi - 1e-6, np.pi]


def rotations(count: int = 20) -> list[tuple[np.ndarray, float]]:
    axes = np.random.default_rng(1).normal(size=(count, 3))
    return [(axis / np.linalg.norm(axis), angle) for axis in axes for angle in ANGLES]


def as_scipy(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(attitude.scalar_last(q))


def test_rotation_matrix_and_product_agree_with_scipy() -> None:
    for axis, angle in rotations():
        q = attitude.from_axis_angle(axis, angle)
        p = attitude.from_axis_angle(axis[::-1], 0.7)
        truth = Rotation.from_rotvec(angle * axis)
        np.testing.assert_allclose(attitude.rotation_matrix(q), truth.as_matrix(), atol=1e-14)
        product = (as_scipy(p) * truth).as_matrix()
        ours = attitude.rotation_matrix(attitude.multiply(p, q))
        np.testing.assert_allclose(ours, product, atol=1e-14)


def test_error_angle_is_accurate_from_nanoradians_to_half_a_turn() -> None:
    for axis, angle in rotations():
        q = attitude.from_axis_angle(axis, angle)
        error = attitude.error_angle(q, attitude.IDENTITY)
        assert abs(error - angle) < 1e-15 + 1e-12 * angle  # rad
        assert attitude.error_angle(-q, attitude.IDENTITY) == error


def test_rotation_vector_undoes_from_axis_angle() -> None:
    for axis, angle in rotations():
        vector = attitude.rotation_vector(attitude.from_axis_angle(axis, angle))
        if angle == np.pi:  # either sense is right at half a turn
            vector = vector * np.sign(vector @ axis)
        np.testing.assert_allclose(vector, angle * axis, atol=1e-14 + 1e-9 * angle)


def test_error_quaternion_is_zero_at_the_target_and_one_sided() -> None:
    q = attitude.from_axis_angle(np.array([1.0, 2.0, -1.0]), 3.0)
    np.testing.assert_allclose(attitude.error_quaternion(q, q), attitude.IDENTITY, atol=1e-15)
    np.testing.assert_allclose(attitude.error_quaternion(-q, q), attitude.IDENTITY, atol=1e-15)
    for axis, angle in rotations(5):
        assert attitude.error_quaternion(attitude.from_axis_angle(axis, 2 * angle), q)[0] >= 0.0


def test_a_history_that_passes_half_a_turn_does_not_jump() -> None:
    """Two turns about one axis: the curves are the half angle's sine and cosine, all along."""
    axis, angle = np.array([0.6, 0.0, 0.8]), np.linspace(0.3, 0.3 + 4 * np.pi, 400)
    truth = np.column_stack([np.cos(angle / 2), np.sin(angle / 2)[:, None] * axis])
    error = attitude.error_quaternion(attitude.from_axis_angle(axis, angle), attitude.IDENTITY)
    assert np.abs(np.diff(error, axis=0)).max() > 1.0  # it jumps when the scalar part turns
    np.testing.assert_allclose(attitude.continuous(error), truth, atol=1e-14)
    np.testing.assert_allclose(attitude.continuous(-error), truth, atol=1e-14)
    rest = attitude.continuous(error[150:], after=truth[149])  # a later part of the same
    np.testing.assert_allclose(rest, truth[150:], atol=1e-14)
    assert attitude.continuous(-error[:1])[0, 0] > 0.0  # starts on the near hemisphere
    assert attitude.continuous(error[:0]).shape == (0, 4)


def test_rotation_by_a_rate_has_the_stated_sense() -> None:
    """q' = 1/2 q (x) (0, omega): a small turn about body x moves body y towards inertial z."""
    dt, omega = 1e-6, np.array([1.0, 0.0, 0.0])
    q = attitude.IDENTITY + 0.5 * dt * attitude.multiply(attitude.IDENTITY, np.array([0, *omega]))
    moved = attitude.rotation_matrix(attitude.normalized(q)) @ np.array([0.0, 1.0, 0.0])
    assert moved[2] == pytest.approx(dt, rel=1e-9)
