"""The optimal control problem: nonlinear least squares over a horizon, under linear limits.

    minimise    1/2 sum_k |r(x_k, u_k, p_k)|^2 + 1/2 |r_N(x_N, p_N)|^2     k = 0 .. N-1
    subject to  x_{k+1} = f(x_k, u_k, p_k),   x_0 given,
                lower <= Cx x_k + Cu u_k <= upper

Every cost here is a sum of squares, so that Gauss-Newton applies: a fourth power is the square of
a squared residual. p holds what may change from one solve to the next (a disturbance, an inertia,
a weight, a reference) without building anything anew; it may differ from stage to stage.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ..ground.arrays import Array, Symbol


@dataclass(frozen=True, eq=False)
class Limits:
    """Rows lower <= Cx x + Cu u <= upper, in units that make them of order one.

    Rows with an input act on stages 0..N-1, rows of the state alone on stages 1..N (x_0 is given).
    Both bounds are finite: leave out a row that has none.
    """

    Cx: Array
    """Shape (rows, nx)."""
    Cu: Array
    """Shape (rows, nu)."""
    lower: Array
    upper: Array
    softness: Array
    """Cost per unit of violation v, which costs w v + w v^2 / 2, shape (rows,); inf is a hard row.
    Rows that the nonlinear state decides must be soft, or a bad start leaves no solution."""

    @property
    def on_input(self) -> Any:
        """Mask of the rows with an input, shape (rows,)."""
        return np.any(self.Cu != 0.0, axis=1)


def no_limits(nx: int, nu: int) -> Limits:
    """A problem without any row."""
    empty = np.zeros(0)
    return Limits(np.zeros((0, nx)), np.zeros((0, nu)), empty, empty, empty)


def join_limits(*parts: Limits) -> Limits:
    """All rows of all parts."""
    names = ("Cx", "Cu", "lower", "upper", "softness")
    return Limits(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True, eq=False)
class Ocp:
    """One stage as CasADi functions, the limits as numbers, the length of the horizon."""

    N: int
    nx: int
    nu: int
    np: int
    evaluate: Any
    """(x, u, p) -> (x_next, r)."""
    linearize: Any
    """(x, u, p) -> (F = dx_next/d(x, u), r, R = dr/d(x, u)), dense."""
    curvature: Any
    """(x, u, p, adjoint) -> Hessian of adjoint'f + |r|^2 / 2 by (x, u), dense."""
    evaluate_end: Any
    """(x, p) -> r_N."""
    linearize_end: Any
    """(x, p) -> (r_N, dr_N/dx), dense."""
    curvature_end: Any
    """(x, p) -> Hessian of |r_N|^2 / 2 by x, dense."""
    limits: Limits


def build_ocp(
    x: Symbol,
    u: Symbol,
    p: Symbol,
    dynamics: Symbol,
    residual: Symbol,
    terminal: Symbol,
    limits: Limits,
    N: int,
) -> Ocp:
    """The problem from SX symbols x, u, p and expressions of them: x_next, r, r_N (of x and p)."""
    z, adjoint = ca.vertcat(x, u), ca.SX.sym("adjoint", x.numel())
    stage_value = ca.dot(adjoint, dynamics) + 0.5 * ca.sumsqr(residual)
    parts = {
        "evaluate": ([x, u, p], [dynamics, residual]),
        "linearize": ([x, u, p], [ca.jacobian(dynamics, z), residual, ca.jacobian(residual, z)]),
        "curvature": ([x, u, p, adjoint], [ca.hessian(stage_value, z)[0]]),
        "evaluate_end": ([x, p], [terminal]),
        "linearize_end": ([x, p], [terminal, ca.jacobian(terminal, x)]),
        "curvature_end": ([x, p], [ca.hessian(0.5 * ca.sumsqr(terminal), x)[0]]),
    }
    functions = {
        name: ca.Function(name, inputs, [ca.densify(output) for output in outputs], {"cse": True})
        for name, (inputs, outputs) in parts.items()
    }
    return Ocp(N, x.numel(), u.numel(), p.numel(), **functions, limits=limits)
