"""The smallest change of a bounded plan that meets a few linear equations, by its small dual.

    minimise 1/2 |u - c|^2 + 1/(2 eps) |C u - d|^2     subject to   lower <= u <= upper

has the solution u = clip(c - C'y) with C u - d = eps y: one equation per row of C, piecewise linear
in y, the gradient of a concave function. Newton's method with backtracking solves it in a handful
of steps whatever the length of u. (Semismooth Newton: Qi and Sun, Math. Programming 58, 1993.)
"""

from typing import Any

import numpy as np

from ...ground.arrays import Array

MAX_STEPS = 30
TOLERANCE = 1e-12
SUFFICIENT = 1e-4  # share of the predicted rise that a step must bring
SMALLEST_STEP = 1e-5  # shorter ones only happen where the equations can't be met


def least_change(c: Array, C: Array, d: Array, lower: Array, upper: Array, eps: float) -> Array:
    """The u above; always inside its bounds. Equations that can't be met are missed by as little
    as the bounds allow."""
    y = np.zeros(len(d))
    u, value, gradient, free = _dual(y, c, C, d, lower, upper, eps)
    for _ in range(MAX_STEPS):
        if np.max(np.abs(gradient)) < TOLERANCE:
            break
        curvature = C[:, free] @ C[:, free].T + eps * np.eye(len(d))
        direction = np.linalg.solve(curvature, gradient)
        slope, step = float(gradient @ direction), 1.0
        while True:
            trial = _dual(y + step * direction, c, C, d, lower, upper, eps)
            if trial[1] >= value + SUFFICIENT * step * slope or step < SMALLEST_STEP:
                break
            step /= 2.0
        if trial[1] <= value:
            break
        y = y + step * direction
        u, value, gradient, free = trial
    return u


def _dual(
    y: Array, c: Array, C: Array, d: Array, lower: Array, upper: Array, eps: float
) -> tuple[Array, float, Array, Any]:
    """Minimiser u at multipliers y, the dual's value and gradient, and which u are off bounds."""
    free = c - C.T @ y
    u = np.clip(free, lower, upper)
    miss = C @ u - d
    value = 0.5 * float((u - c) @ (u - c)) + float(y @ miss) - 0.5 * eps * float(y @ y)
    return u, value, miss - eps * y, (free > lower) & (free < upper)
