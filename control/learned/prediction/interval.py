"""One interval of a plan, and the plan's end, as CasADi functions.

One interval of length h with torque u after u_prev; the spin momenta p_1 at its end and p_mean over
it, the motors' ramps included, are those of `model.ramp`:

    theta  = h w + h^2 / 12  w x (w_1 - w_0)         w = omega(q_half, p_mean)
    q_1    = q (x) exp(theta / 2)                q_half = q (x) exp(h omega(q, p) / 4)

the fourth-order Magnus step (Iserles and others, Acta Numerica 2000, section 5; sign for body
rates). Where a network predicts the appendage momentum c (see `model.appendage`), c joins A p: at
the interval's start, its mean, and at its end. The state is (q, p, u_prev), with a network (q, p,
u_prev, c, c a period before, u a period before).

A spacecraft's and a network's numbers are an input, so that the functions, and what is compiled
from them, serve every craft with as many wheels.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...ground.arrays import Array, Symbol
from ...ground.spacecraft import Spacecraft
from ...ground.turn import turned_symbolic
from ...model.appendage import AppendageNetwork, NetworkSize, symbolic_momentum
from ...model.momentum import actuated_basis
from ...model.ramp import ramped_spin
from ...model.rotation import in_body, vector_from

KNOWN = 12  # J_hub^-1 by columns, h_N


@dataclass(frozen=True, eq=False)
class IntervalFunctions:
    """The functions; known is (J_hub^-1, h_N), numbers those of `numbers_of`."""

    step: Any
    """(x, u, h, known, numbers) -> x after the interval."""
    step_slope: Any
    """The same and its derivative by (x, u), dense."""
    end: Any
    """(x, goal, known, numbers) -> end. goal is the attitude (body -> inertial) to end in; end = (2
    q_v of the attitude from the goal (3), momentum that wheels must still take up, B'(A p - R'h_N),
    over the mean inertia (rank)): rad, rad/s. With a network also (J_hub^-1 c at the end, and a
    period before it): rates, rad/s, with which the body still swings."""
    end_slope: Any
    """The same and its derivative by x, dense."""
    even: bool
    """Whether all intervals must be as long as a network's period."""

    @property
    def states(self) -> int:
        """Length of x."""
        return int(self.step.numel_in(0))

    @property
    def wheels(self) -> int:
        """Length of u."""
        return int(self.step.numel_in(1))

    @property
    def conditions(self) -> int:
        """Length of end."""
        return int(self.end.numel_out(0))


def numbers_of(spacecraft: Spacecraft, network: AppendageNetwork | None) -> Array:
    """A, rate limits, B, mean inertia, and the network's numbers."""
    basis, size = actuated_basis(spacecraft), np.trace(spacecraft.J) / 3.0
    parts = [spacecraft.A.ravel("F"), spacecraft.torque_rate_max, basis.ravel("F"), [size]]
    return np.concatenate([*parts, [] if network is None else network.numbers])


@lru_cache(maxsize=8)
def interval_functions(wheels: int, rank: int, network: NetworkSize | None) -> IntervalFunctions:
    """The functions of all craft with so many wheels that span so many axes, and a network of that
    size or none."""
    lengths = [3 * wheels, wheels, 3 * rank, 1, 0 if network is None else network.count]
    numbers = [ca.SX.sym("number", n) for n in lengths]
    A, rate_max, basis, size, weights = numbers
    A, basis = ca.reshape(A, 3, wheels), ca.reshape(basis, 3, rank)
    known, h, goal = ca.SX.sym("known", KNOWN), ca.SX.sym("h"), ca.SX.sym("goal", 4)
    q, p, before, u = (
        ca.SX.sym(name, n) for name, n in zip("qpbu", (4, *[wheels] * 3), strict=True)
    )
    inverse, h_N = ca.reshape(known[:9], 3, 3), known[9:]

    reached, p_next, p_mean = ramped_spin(p, u, before, h, rate_max)
    carried = [A @ p, A @ p_mean, A @ p_next]
    own: list[Symbol] = []
    own_next: list[Symbol] = []
    if network is not None:
        own, own_next, momenta = _appendages(network, weights, u, before, p_mean)
        carried = [wheel + c for wheel, c in zip(carried, momenta, strict=True)]
    swings = [inverse @ c for c in own[:2]]
    x, q_next = ca.vertcat(q, p, before, *own), _turned_by(q, h, inverse, h_N, carried)
    x_next = ca.vertcat(q_next, p_next, reached, *own_next)
    left = basis.T @ (A @ p - in_body(q, h_N)) / size
    end = ca.vertcat(2.0 * vector_from(q, goal), left, *swings)

    step_in = [x, u, h, known, ca.vertcat(*numbers)]
    end_in = [x, goal, known, ca.vertcat(*numbers)]
    return IntervalFunctions(
        _function("plan_step", step_in, [x_next]),
        _function("plan_step_slope", step_in, [x_next, ca.jacobian(x_next, ca.vertcat(x, u))]),
        _function("plan_end", end_in, [end]),
        _function("plan_end_slope", end_in, [end, ca.jacobian(end, x)]),
        even=network is not None,
    )


def _function(name: str, inputs: list[Symbol], outputs: list[Symbol]) -> Any:
    return ca.Function(name, inputs, list(map(ca.densify, outputs)), {"cse": True})


def _appendages(
    network: NetworkSize, weights: Symbol, u: Symbol, previous: Symbol, p_mean: Symbol
) -> tuple[list[Symbol], list[Symbol], list[Symbol]]:
    """The network's own states (c, c and u a period before), their successors, and (c, its mean, c
    at the end)."""
    c, c_before, before = ca.SX.sym("c", 3), ca.SX.sym("d", 3), ca.SX.sym("w", network.wheels)
    c_next, c_mean = symbolic_momentum(network, weights, c, c_before, u, previous, before, p_mean)
    return [c, c_before, before], [c_next, c, previous], [c, c_mean, c_next]


def _turned_by(q: Symbol, h: Symbol, inverse: Symbol, h_N: Symbol, carried: list[Symbol]) -> Symbol:
    """Attitude after the interval; `carried` is the momentum of wheels and appendages at its start,
    its mean, and at its end, body axes."""
    start, mean, end = carried
    q_half = turned_symbolic(q, h / 2.0 * (inverse @ (in_body(q, h_N) - start)))
    rate = inverse @ (in_body(q_half, h_N) - mean)
    theta = h * rate + h * h / 12.0 * ca.cross(rate, inverse @ (start - end))
    return turned_symbolic(q, theta)
