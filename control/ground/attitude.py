"""Quaternion algebra of attitudes.

One convention everywhere: unit quaternions, **scalar first** (w, x, y, z), Hamilton product,
**body -> inertial**: ``v_N = R(q) v_B`` and ``q' = 1/2 q (x) (0, omega)`` with omega the rate of
B relative to N in body axes. q and -q are the same attitude. rerun and SciPy want (x, y, z, w):
convert at their door with `scalar_last`.

Every function takes a batch in the leading axes. Source: Schaub and Junkins, Analytical Mechanics
of Space Systems, 4th ed., section 3.4.
"""

import numpy as np

from .arrays import Array, Matrices3, Quaternion, Quaternions, Vectors3

IDENTITY: Quaternion = np.array([1.0, 0.0, 0.0, 0.0])


def multiply(p: Quaternions, q: Quaternions) -> Quaternions:
    """Hamilton product p (x) q: R(p (x) q) = R(p) R(q)."""
    pw, px, py, pz = np.moveaxis(np.asarray(p, float), -1, 0)
    qw, qx, qy, qz = np.moveaxis(np.asarray(q, float), -1, 0)
    return np.stack(
        [
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ],
        axis=-1,
    )


def conjugate(q: Quaternions) -> Quaternions:
    """Inverse rotation of a unit quaternion."""
    return np.asarray(q, float) * np.array([1.0, -1.0, -1.0, -1.0])


def normalized(q: Array) -> Array:
    """q / |q| over the last axis, which may have any length."""
    q = np.asarray(q, float)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def near_hemisphere(q: Quaternions) -> Quaternions:
    """The one of q and -q whose scalar part is not negative: the short way round."""
    q = np.asarray(q, float)
    return np.where(q[..., :1] < 0.0, -q, q)


def continuous(q: Quaternions, after: Quaternion = IDENTITY) -> Quaternions:
    """A history of attitudes, shape (rows, 4), as curves without a jump: each with the one of its
    two signs that is nearer to the one before, the first nearer to `after`.

    So that a history starts on the near hemisphere and may leave it. Attitudes that follow each
    other must be less than half a turn apart.
    """
    chain = np.concatenate([[after], q])
    back = np.sum(chain[1:] * chain[:-1], axis=-1) < 0.0
    return np.where(np.cumsum(back)[:, None] % 2 == 1, -chain[1:], chain[1:])


def from_axis_angle(axis: Vectors3, angle: float | Array) -> Quaternions:
    """Rotation by `angle` (rad) about `axis` (any length but zero)."""
    axis = np.asarray(axis, float)
    axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    half = np.asarray(angle, float)[..., None] / 2.0
    return np.concatenate([np.cos(half), np.sin(half) * axis], axis=-1)


def rotation_matrix(q: Quaternions) -> Matrices3:
    """R(q), which maps body components to inertial ones: v_N = R(q) v_B."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotation_vector(q: Quaternions) -> Vectors3:
    """Axis times angle (rad) of the short way round, accurate near zero and near pi."""
    q = near_hemisphere(q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.where(sine > 0.0, angle / sine, 2.0)
    return q[..., 1:] * scale


def error_quaternion(q: Quaternions, q_target: Quaternions) -> Quaternions:
    """Attitude of the body relative to the target, q_BT = q_target^-1 (x) q, scalar part >= 0."""
    return near_hemisphere(multiply(conjugate(q_target), q))


def error_angle(q: Quaternions, q_target: Quaternions) -> Array:
    """Angle (rad) between two attitudes, 2 atan2(|q_v|, |q_0|): in [0, pi], accurate near zero."""
    error = multiply(conjugate(q_target), q)
    return 2.0 * np.arctan2(np.linalg.norm(error[..., 1:], axis=-1), np.abs(error[..., 0]))


def scalar_last(q: Quaternions) -> Array:
    """(w, x, y, z) -> (x, y, z, w), the order of rerun and SciPy."""
    return np.roll(np.asarray(q, float), -1, axis=-1)
