"""Vectors as three components, each a float or an array of samples.

The plant asks for one torque per 50 ms tick, where plain floats are ten times faster than small
arrays; the log asks for thousands of samples at once. Written on components, one formula serves
both. Only functions that floats and arrays understand alike belong here.
"""

import math
from typing import TypeAlias

import numpy as np

from simsat.control.ground.arrays import Array

Number: TypeAlias = float | Array
"""One value, or an array of samples."""

Triple: TypeAlias = tuple[Number, Number, Number]
"""Components of a vector."""

Rows: TypeAlias = tuple[Triple, Triple, Triple]
"""Rows of a 3 x 3 matrix."""


def dot(a: Triple, b: Triple) -> Number:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Triple, b: Triple) -> Triple:
    """a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def scaled(factor: Number, a: Triple) -> Triple:
    """factor * a."""
    return factor * a[0], factor * a[1], factor * a[2]


def added(a: Triple, b: Triple) -> Triple:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def combined(c: Number, a: Triple, s: Number, b: Triple) -> Triple:
    """c a + s b."""
    return c * a[0] + s * b[0], c * a[1] + s * b[1], c * a[2] + s * b[2]


def applied(matrix: Rows, a: Triple) -> Triple:
    """matrix . a."""
    return dot(matrix[0], a), dot(matrix[1], a), dot(matrix[2], a)


def cos_sin(angle: Number) -> tuple[Number, Number]:
    """Cosine and sine of an angle in rad."""
    if isinstance(angle, float):
        return math.cos(angle), math.sin(angle)
    return np.cos(angle), np.sin(angle)


def inertial_to_body(q: tuple[Number, Number, Number, Number]) -> Rows:
    """R(q)', which maps inertial components to body ones (q body -> inertial, scalar first)."""
    w, x, y, z = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        (2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def triple(vector: Array) -> Triple:
    """Components of one vector, shape (3,), as plain floats."""
    x, y, z = (float(component) for component in vector)
    return x, y, z


def rows(matrix: Array) -> Rows:
    """Rows of one matrix, shape (3, 3), as plain floats."""
    return triple(matrix[0]), triple(matrix[1]), triple(matrix[2])
