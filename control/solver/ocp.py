"""The optimal control problem: nonlinear least squares over a horizon, under linear limits.

    minimise    1/2 sum_k |r(x_k, u_k, p_k)|^2 + 1/2 |r_N(x_N, p_N)|^2     k = 0 .. N-1
    subject to  x_{k+1} = f(x_k, u_k, p_k),   x_0 given,
                lower <= Cx x_k + Cu u_k <= upper

Every cost here is a sum of squares, so that Gauss-Newton applies: a fourth power is the square of
a squared residual. p holds what may change from one solve to the next (a disturbance, a reference)
and from stage to stage. Numbers that stay for the whole problem (an inertia, a weight) are the
stage's coefficients (`stage.py`). Neither makes anything be built or compiled anew.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ..ground.arrays import Array, Symbol
from .stage import Stage, build_stage


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
    """A stage, the numbers of this problem, the limits, the length of the horizon."""

    stage: Stage
    coefficients: Array
    """`Stage.coefficients` of this problem's numbers, shape (nc,)."""
    limits: Limits
    N: int

    @property
    def nx(self) -> int:
        """Number of states."""
        return self.stage.nx

    @property
    def nu(self) -> int:
        """Number of inputs."""
        return self.stage.nu

    @property
    def np(self) -> int:
        """Number of parameters of a stage."""
        return self.stage.np

    def evaluate(self, x: Symbol, u: Symbol, p: Symbol) -> Any:
        """(x_next, r) of numbers or symbols."""
        return self.stage.evaluate(x, u, p, self.coefficients)

    def evaluate_end(self, x: Symbol, p: Symbol) -> Any:
        """r_N of numbers or symbols."""
        return self.stage.evaluate_end(x, p, self.coefficients)


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
    stage = build_stage(x, u, p, ca.SX(0, 1), dynamics, residual, terminal)
    return Ocp(stage, np.zeros(0), limits, N)
