"""The attitude after a turn, q (x) exp(theta / 2): once for each kind of number that needs it.

    exp(theta / 2) = (cos |theta|/2,  theta/2 sinc |theta|/2)

theta is the rotation vector in body axes, rad. Arrays take batches; plain floats serve the plant's
inner loop, where NumPy's overhead on four numbers would be most of the time; the CasADi form is a
series, smooth at zero, where the norm has no derivative.
"""

import math

import casadi as ca
import numpy as np

from .arrays import Quaternion, Quaternions, Symbol, Vector3, Vectors3
from .attitude import multiply

Floats4 = tuple[float, float, float, float]


def rotation_by(theta: Vectors3) -> Quaternions:
    """exp(theta / 2), shape (..., 4)."""
    half = 0.5 * np.linalg.norm(theta, axis=-1, keepdims=True)
    vector = 0.5 * np.sinc(half / np.pi) * theta
    return np.concatenate([np.cos(half), vector], axis=-1)


def turned(q: Quaternions, theta: Vectors3) -> Quaternions:
    """q (x) exp(theta / 2), shape (..., 4)."""
    return multiply(q, rotation_by(theta))


def turned_floats(q: Quaternion, half: Vector3) -> Floats4:
    """The same of one quaternion and half a rotation vector, in plain floats."""
    w, x, y, z = q.tolist()
    a, b, c = half.tolist()
    angle = math.sqrt(a * a + b * b + c * c)
    s = math.sin(angle) / angle if angle > 1e-12 else 1.0
    e, a, b, c = math.cos(angle), s * a, s * b, s * c
    return (
        w * e - x * a - y * b - z * c,
        w * a + x * e + y * c - z * b,
        w * b - x * c + y * e + z * a,
        w * c + x * b - y * a + z * e,
    )


def turned_symbolic(q: Symbol, theta: Symbol) -> Symbol:
    """The same of CasADi columns, by series of cos and sinc: good to 1e-9 below 1 rad."""
    s = ca.dot(theta, theta) / 4.0
    cosine = 1.0 - s / 2.0 * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0)))
    sinc = 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)))
    v = 0.5 * sinc * theta
    return ca.vertcat(
        q[0] * cosine - ca.dot(q[1:], v), q[0] * v + cosine * q[1:] + ca.cross(q[1:], v)
    )
