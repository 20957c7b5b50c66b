"""Where a sequence of wheel torques leads: the end of the plan and its slope, in CasADi.

One interval of length h with torque u after u_prev; the spin momenta p_1 at its end and p_mean over
it, the motors' ramps included, are those of `model.ramp`:

    theta  = h w + h^2 / 12  w x (w_1 - w_0)         w = omega(q_half, p_mean)
    q_1    = q (x) exp(theta / 2)                q_half = q (x) exp(h omega(q, p) / 4)

the fourth-order Magnus step (Iserles and others, Acta Numerica 2000, section 5; sign for body
rates). Where a network predicts the appendage momentum c (see `model.appendage`), c joins A p: at
the interval's start, its mean, and at its end. The state is (q, p, u_prev), with a network (q, p,
u_prev, c, c a period before, u a period before).

An interval of length zero changes nothing, so a function serves all plans up to its own length; a
few lengths are built, and the shortest that fits is evaluated.
"""

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from ...ground.arrays import Array, Quaternion, Symbol
from ...ground.spacecraft import Spacecraft
from ...ground.turn import turned_symbolic
from ...model.appendage import AppendageNetwork, symbolic_momentum
from ...model.momentum import MomentumModel, actuated_basis
from ...model.ramp import ramped_spin
from ...model.rotation import in_body, vector_from

LENGTHS = (8, 24, 40, 64)  # intervals; the longest plan takes 32 s at 2 Hz

Propagators = Mapping[int, Any]
"""CasADi functions by the number of intervals that they hold."""


def state_size(wheels: int, network: AppendageNetwork | None) -> int:
    """Length of the state."""
    return 4 + 2 * wheels if network is None else 10 + 3 * wheels


def build_propagators(
    spacecraft: Spacecraft, network: AppendageNetwork | None = None
) -> Propagators:
    """CasADi functions (x0, U, h, J_hub^-1, h_N, goal) -> (end, d end / d vec(U), x) by length N.

    U of shape (m, N), h of shape (N); goal is the attitude (body -> inertial) to end in. end = (2
    q_v of the attitude from the goal (3), momentum that wheels must still take up, B'(A p - R'h_N),
    over the mean inertia (rank)): rad, rad/s. With a network also (J_hub^-1 c at the end, and a
    period before it): rates, rad/s, with which the body still swings.
    """
    return {N: _build_propagator(spacecraft, network, N) for N in LENGTHS}


def propagate(
    propagators: Propagators,
    model: MomentumModel,
    x0: Array,
    torque: Array,
    period: float,
    goal: Quaternion,
) -> tuple[Array, Array, Array]:
    """End (3 + rank), its slope by the torques (3 + rank, K m), and the states (K + 1, 4 + 2 m) of
    a plan of shape (K, m)."""
    K, m = torque.shape
    N = min(length for length in propagators if length >= K)
    U, h = np.zeros((m, N)), np.zeros(N)
    U[:, :K], h[:K] = torque.T, period
    out = propagators[N](x0, U, h, model.J_hub_inverse, model.h_N, goal)
    end, slope, x = (np.array(part) for part in out)
    return end.ravel(), slope[:, : K * m], np.vstack([x0, x[:, :K].T])


def _build_propagator(spacecraft: Spacecraft, network: AppendageNetwork | None, N: int) -> Any:
    m = spacecraft.wheels
    x0, U, h = ca.MX.sym("x0", state_size(m, network)), ca.MX.sym("U", m, N), ca.MX.sym("h", N)
    inverse, h_N, goal = ca.MX.sym("Ji", 3, 3), ca.MX.sym("h_N", 3), ca.MX.sym("goal", 4)
    shared = ca.repmat(ca.vertcat(ca.vec(inverse), h_N), 1, N)
    x = _interval(spacecraft, network).mapaccum(N)(x0, U, h.T, shared)
    end = _end(spacecraft, x[:, -1], h_N, goal)
    if network is not None:
        c, before = x[4 + 2 * m : 7 + 2 * m, -1], x[7 + 2 * m : 10 + 2 * m, -1]
        end = ca.vertcat(end, inverse @ c, inverse @ before)
    slope = ca.jacobian(end, ca.vec(U))
    return ca.Function("propagate", [x0, U, h, inverse, h_N, goal], [end, slope, x]).expand()


def _end(spacecraft: Spacecraft, x: Symbol, h_N: Symbol, goal: Symbol) -> Symbol:
    """Attitude from the goal and momentum still to be taken up, in the last state."""
    q, p = x[:4], x[4 : 4 + spacecraft.wheels]
    B, size = actuated_basis(spacecraft), np.trace(spacecraft.J) / 3.0
    left = ca.DM(B.T) @ (ca.DM(spacecraft.A) @ p - in_body(q, h_N)) / size
    return ca.vertcat(2.0 * vector_from(q, goal), left)


def _interval(spacecraft: Spacecraft, network: AppendageNetwork | None) -> Any:
    """CasADi function (x, u, h, (J_hub^-1, h_N)) -> x after one interval."""
    m = spacecraft.wheels
    q, p, previous, u = (ca.SX.sym(name, n) for name, n in zip("qpvu", (4, m, m, m), strict=True))
    h, shared = ca.SX.sym("h"), ca.SX.sym("shared", 12)
    lasts = ca.if_else(h > 0.0, 1.0, 0.0)
    p_next, p_mean = ramped_spin(spacecraft, p, u, previous, h)
    A = ca.DM(spacecraft.A)
    carried = [A @ p, A @ p_mean, A @ p_next]
    x, x_next = [q, p, previous], [p_next, lasts * u + (1.0 - lasts) * previous]
    if network is not None:
        own, own_next, momenta = _appendage_step(network, u, previous, p_mean, lasts)
        carried = [wheels + c for wheels, c in zip(carried, momenta, strict=True)]
        x, x_next = x + own, x_next + own_next
    x_next.insert(0, _turned_by(q, h, shared, carried))
    return ca.Function("interval", [ca.vertcat(*x), u, h, shared], [ca.vertcat(*x_next)])


def _appendage_step(
    network: AppendageNetwork, u: Symbol, previous: Symbol, p_mean: Symbol, lasts: Symbol
) -> tuple[list[Symbol], list[Symbol], list[Symbol]]:
    """The network's own states (c, c and u a period before), their successors, and (c, its mean, c
    at the end)."""
    c, c_before, before = ca.SX.sym("c", 3), ca.SX.sym("d", 3), ca.SX.sym("w", network.wheels)
    c_next, c_mean = symbolic_momentum(network, c, c_before, u, previous, before, p_mean)
    own, moved = [c, c_before, before], (c_next, c, previous)
    own_next = [lasts * new + (1.0 - lasts) * old for new, old in zip(moved, own, strict=True)]
    return own, own_next, [c, c_mean, c_next]


def _turned_by(q: Symbol, h: Symbol, shared: Symbol, carried: list[Symbol]) -> Symbol:
    """Attitude after the interval; `carried` is the momentum of wheels and appendages at its start,
    its mean, and at its end, body axes."""
    inverse, h_N = ca.reshape(shared[:9], 3, 3), shared[9:]
    start, mean, end = carried
    q_half = turned_symbolic(q, h / 2.0 * (inverse @ (in_body(q, h_N) - start)))
    rate = inverse @ (in_body(q_half, h_N) - mean)
    theta = h * rate + h * h / 12.0 * ca.cross(rate, inverse @ (start - end))
    return turned_symbolic(q, theta)
