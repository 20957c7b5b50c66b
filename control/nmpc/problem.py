"""The attitude problem's stage, one for all spacecraft and settings of the same structure.

What belongs to the structure, so that functions are built and compiled anew for it: the wheels'
axes A, whether friction is in the prediction, whether an axis is unactuated, and which wheels have
no rate limit, since they don't ramp. All else is free: inertia, rotor inertia, friction
coefficients, limits, weights and period, so that a study over them compiles once. (The zeros of a
diagonal inertia are computed for it: a solve takes 13 % longer than without them.) A horizon or
another number of limits is compiled anew, but not built anew.
"""

from dataclasses import asdict, fields
from functools import lru_cache, partial
from types import SimpleNamespace
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ..ground.arrays import Array, Symbol, WheelVector
from ..ground.spacecraft import Spacecraft
from ..model.dynamics import friction_torque, invert_hub, rk4_step, state_derivative
from ..model.ramp import mean_rounded_torque, ramp_numbers
from ..solver.stage import Stage, build_stage
from .cost import Weights, input_residual, state_residual

RAMP = ("slowness", "rounding")

Axes = tuple[tuple[float, ...], ...]


class Pattern(NamedTuple):
    """Which entries of a named array are not zero."""

    name: str
    rows: int
    columns: int
    places: tuple[int, ...]
    """Counted by columns, as CasADi does."""


def attitude_stage(
    spacecraft: Spacecraft, weights: Weights, period: float, scale: WheelVector, friction: bool
) -> tuple[Stage, Array]:
    """The stage with x = (q_BT, omega, Omega, u_prev) and p = tau_d, and its coefficients.

    `scale` is the motor torque that counts as one in the cost, Nm.
    """
    arrays = _arrays(spacecraft, weights, period, scale, friction)
    patterns = tuple(_pattern(name, array) for name, array in arrays.items())
    stage = _build(tuple(map(tuple, spacecraft.A.tolist())), patterns)
    numbers = [arrays[at.name].ravel(order="F")[list(at.places)] for at in patterns]
    return stage, stage.coefficients(np.concatenate(numbers))


def _arrays(
    spacecraft: Spacecraft, weights: Weights, period: float, scale: WheelVector, friction: bool
) -> dict[str, Array]:
    """The free numbers, each of two dimensions."""
    slowness, rounding = ramp_numbers(spacecraft.torque_rate_max, period)
    J, A, Js = ca.DM(spacecraft.J), ca.DM(spacecraft.A), ca.DM(spacecraft.Js)
    numbers: dict[str, Any] = {
        "J": J,
        "hub_inverse": invert_hub(J, A, Js),
        "Js": Js,
        "scale": scale,
        "slowness": slowness,
        "rounding": rounding,
        "period": period,
        "weights": list(asdict(weights).values()),
    }
    if friction:
        numbers |= {"viscous": spacecraft.viscous, "coulomb": spacecraft.coulomb}
    if spacecraft.loop_normal is not None:
        numbers |= {"normal": spacecraft.loop_normal}
    return {name: np.array(ca.DM(number)) for name, number in numbers.items()}


def _pattern(name: str, array: Array) -> Pattern:
    """A number may be zero without another structure, unless it says that there is no ramp."""
    there = array.ravel(order="F") if name in RAMP else np.ones(array.size)
    rows, columns = array.shape
    return Pattern(name, rows, columns, tuple(np.flatnonzero(there).tolist()))


@lru_cache(maxsize=8)
def _build(axes: Axes, patterns: tuple[Pattern, ...]) -> Stage:
    A, m = ca.DM(axes), len(axes[0])
    symbols = {
        at.name: ca.SX.sym(at.name, ca.Sparsity.nonzeros(at.rows, at.columns, at.places))
        for at in patterns
    }
    the = SimpleNamespace(**symbols)
    names = [field.name for field in fields(Weights)]
    weights = SimpleNamespace(**dict(zip(names, ca.vertsplit(the.weights), strict=True)))
    x, u, tau_d = ca.SX.sym("x", 7 + 2 * m), ca.SX.sym("u", m), ca.SX.sym("tau_d", 3)
    previous = x[7 + m :]
    torque = mean_rounded_torque(u, previous, the.slowness, the.rounding)

    def derivative(s: Symbol) -> Symbol:
        friction = friction_torque(the.viscous, the.coulomb, s[7:]) if "viscous" in symbols else 0.0
        return state_derivative(s, torque, tau_d, the.J, the.hub_inverse, A, the.Js, friction)

    cost_of_state = partial(state_residual, x[:4], x[4:7], weights, symbols.get("normal"))
    return build_stage(
        x,
        u,
        tau_d,
        numbers=ca.vertcat(*(symbol.nz[:] for symbol in symbols.values() if symbol.nnz())),
        dynamics=ca.vertcat(rk4_step(derivative, x[: 7 + m], the.period), u),
        residual=ca.vertcat(cost_of_state(), input_residual(u, previous, the.scale, weights)),
        terminal=cost_of_state(weights.terminal),
    )
