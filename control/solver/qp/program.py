"""The dense convex quadratic program that a Gauss-Newton or Newton step solves.

minimise    1/2 v'Hv + g'v + sum over soft rows of (w s + w s^2 / 2)
subject to  lower - s <= D v <= upper + s,   s >= 0 on soft rows, s = 0 on hard ones
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from ...ground.arrays import Array

Places: TypeAlias = NDArray[np.int_]
"""Where each row ends, shape (rows,): one of the following, positive above, negative below."""

Mask: TypeAlias = NDArray[np.bool_]

INSIDE, AT_BOUND, BEYOND = 0, 1, 2


@dataclass(frozen=True, eq=False)
class QuadraticProgram:
    """The problem above, positive definite H."""

    H: Array
    g: Array
    D: Array
    lower: Array
    upper: Array
    softness: Array
    """w of each row; inf on hard ones."""

    @cached_property
    def limit(self) -> Array:
        """(upper, -lower), shape (2, rows)."""
        return np.stack([self.upper, -self.lower])

    @cached_property
    def soft(self) -> Mask:
        """Mask of the soft rows."""
        return np.isfinite(self.softness)

    @cached_property
    def w(self) -> Array:
        """Softness, with 0 on hard rows."""
        return np.where(self.soft, self.softness, 0.0)


@dataclass(frozen=True, eq=False)
class QpSolution:
    """Minimiser v, multipliers of the rows (positive: upper), where rows end, factorisations."""

    v: Array
    multipliers: Array
    place: Places
    factorizations: int


def cholesky(H: Array) -> Any:
    """Lower Cholesky factor of H; not numbers where H is not positive definite."""
    factor, trouble = lapack.dpotrf(H, lower=1)
    return factor if trouble == 0 else np.full_like(H, np.nan)


def cholesky_solve(factor: Array, right: Array) -> Any:
    """H^-1 right, from H's factor."""
    return lapack.dpotrs(factor, right, lower=1)[0]


def is_convex(H: Array) -> bool:
    """Whether H is positive definite."""
    return bool(lapack.dpotrf(H, lower=1)[1] == 0)
