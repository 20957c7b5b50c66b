"""One stage of an optimal control problem as CasADi functions, whatever the problem's numbers.

An inertia or a weight does not change the functions: it stands in them as a symbol. What follows
from such numbers alone is computed once for each problem, outside the functions: the coefficients
c, their last input. So they are hardly longer than with the numbers written in, and a library
compiled from them serves every problem of the same structure.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ..ground.arrays import Array, Symbol

Outputs = dict[str, list[Symbol]]


@dataclass(frozen=True, eq=False)
class Stage:
    """The functions of a stage; c is the same at all stages of a problem."""

    nx: int
    nu: int
    np: int
    nc: int
    evaluate: Any
    """(x, u, p, c) -> (x_next, r)."""
    linearize: Any
    """(x, u, p, c) -> (F = dx_next/d(x, u), r, R = dr/d(x, u)), dense."""
    curvature: Any
    """(x, u, p, c, adjoint) -> Hessian of adjoint'f + |r|^2 / 2 by (x, u), dense."""
    evaluate_end: Any
    """(x, p, c) -> r_N."""
    linearize_end: Any
    """(x, p, c) -> (r_N, dr_N/dx), dense."""
    curvature_end: Any
    """(x, p, c) -> Hessian of |r_N|^2 / 2 by x, dense."""
    combine: Any
    """numbers -> c."""

    def coefficients(self, numbers: Array) -> Array:
        """c of a problem's numbers, shape (nc,)."""
        return np.asarray(self.combine(numbers)).ravel()


def build_stage(
    x: Symbol,
    u: Symbol,
    p: Symbol,
    numbers: Symbol,
    dynamics: Symbol,
    residual: Symbol,
    terminal: Symbol,
) -> Stage:
    """From SX symbols and expressions of them: x_next, r, r_N (of x, p and numbers)."""
    z, adjoint = ca.vertcat(x, u), ca.SX.sym("adjoint", x.numel())
    stage_value = ca.dot(adjoint, dynamics) + 0.5 * ca.sumsqr(residual)
    outputs, c, combined = _without(
        numbers,
        {
            "evaluate": [dynamics, residual],
            "linearize": [ca.jacobian(dynamics, z), residual, ca.jacobian(residual, z)],
            "curvature": [ca.hessian(stage_value, z)[0]],
            "evaluate_end": [terminal],
            "linearize_end": [terminal, ca.jacobian(terminal, x)],
            "curvature_end": [ca.hessian(0.5 * ca.sumsqr(terminal), x)[0]],
        },
    )
    inputs = {name: [x, p, c] if name.endswith("_end") else [x, u, p, c] for name in outputs}
    inputs["curvature"].append(adjoint)
    functions = {
        name: ca.Function(name, inputs[name], list(map(ca.densify, outputs[name])), {"cse": True})
        for name in outputs
    }
    combine = ca.Function("combine", [numbers], [combined])
    return Stage(x.numel(), u.numel(), p.numel(), c.numel(), **functions, combine=combine)


def _without(numbers: Symbol, outputs: Outputs) -> tuple[Outputs, Symbol, Symbol]:
    """The outputs as expressions of c in place of the numbers, c, and c as one of the numbers."""
    together = ca.cse([output for listed in outputs.values() for output in listed])
    together, c, combined = ca.extract_parametric(together, numbers, {"extract_trivial": True})
    rest = iter(together)
    outputs = {name: [next(rest) for _ in listed] for name, listed in outputs.items()}
    empty = ca.SX(0, 1)
    return outputs, ca.vertcat(empty, *c), ca.vertcat(empty, *combined)
