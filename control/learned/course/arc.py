"""Where a sequence of wheel torques leads: the end of the plan and its slope, in CasADi.

One interval of length h with torque u after u_prev, the motor's rate limit included in closed form
(ramp time tau = |u - u_prev| / rate):

    p_1    = p + h u - (u - u_prev) tau / 2
    p_mean = p + h u / 2 - (u - u_prev) (tau / 2 - tau^2 / (6 h))
    theta  = h w + h^2 / 12  w x (w_1 - w_0)         w = omega(q_half, p_mean)
    q_1    = q (x) exp(theta / 2)                q_half = q (x) exp(h omega(q, p) / 4)

the fourth-order Magnus step (Iserles and others, Acta Numerica 2000, section 5; sign for body
rates). Where a network predicts the momentum c of what is loose (see `appendage`), c joins A p: at
the interval's start, its mean, and at its end. The state is (q, p, u_prev), with a network (q, p,
u_prev, c, c a period before, u a period before).

An interval of length zero changes nothing, so a function serves all plans up to its own length; a
few lengths are built, and the shortest that fits is evaluated.
"""

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from ...ground.arrays import Array, Quaternion
from ...ground.spacecraft import Spacecraft
from ...model.appendage import AppendageNetwork, symbolic
from ...model.momentum import MomentumModel, actuated_basis

Symbol = Any
LENGTHS = (8, 24, 40, 64)  # intervals; the longest plan takes 32 s at 2 Hz

Arcs = Mapping[int, Any]
"""Arc functions by their length."""


def state_size(wheels: int, network: AppendageNetwork | None) -> int:
    """Length of an arc's state."""
    return 4 + 2 * wheels if network is None else 10 + 3 * wheels


def build_arcs(spacecraft: Spacecraft, network: AppendageNetwork | None = None) -> Arcs:
    """CasADi functions (x0, U, h, J_hub^-1, h_N, goal) -> (end, d end / d vec(U), x) by length N.

    U of shape (m, N), h of shape (N); goal is the attitude (body -> inertial) to end in. end = (2
    q_v of the attitude from the goal (3), momentum that wheels must still take up, B'(A p - R'h_N),
    over the mean inertia (rank)): rad, rad/s. With a network also (J_hub^-1 c at the end, and a
    period before it): rates, rad/s, with which the body still swings.
    """
    return {N: _build_arc(spacecraft, network, N) for N in LENGTHS}


def _build_arc(spacecraft: Spacecraft, network: AppendageNetwork | None, N: int) -> Any:
    m = spacecraft.wheels
    x0, U, h = ca.MX.sym("x0", state_size(m, network)), ca.MX.sym("U", m, N), ca.MX.sym("h", N)
    inverse, h_N, goal = ca.MX.sym("Ji", 3, 3), ca.MX.sym("h_N", 3), ca.MX.sym("goal", 4)
    steps = _interval(spacecraft, network).mapaccum(N)
    shared = ca.repmat(ca.vertcat(ca.vec(inverse), h_N), 1, N)
    x = steps(x0, U, h.T, shared)
    q, p = x[:4, -1], x[4 : 4 + m, -1]
    B, size = actuated_basis(spacecraft), np.trace(spacecraft.J) / 3.0
    left = ca.DM(B.T) @ (ca.DM(spacecraft.A) @ p - in_body(q, h_N)) / size
    end = ca.vertcat(2.0 * vector_from(q, goal), left)
    if network is not None:
        c, before = x[4 + 2 * m : 7 + 2 * m, -1], x[7 + 2 * m : 10 + 2 * m, -1]
        end = ca.vertcat(end, inverse @ c, inverse @ before)
    slope = ca.jacobian(end, ca.vec(U))
    return ca.Function("arc", [x0, U, h, inverse, h_N, goal], [end, slope, x]).expand()


def fly_arc(
    arcs: Arcs, model: MomentumModel, x0: Array, torque: Array, period: float, goal: Quaternion
) -> tuple[Array, Array, Array]:
    """End (3 + rank), its slope by the torques (3 + rank, K m), and the states (K + 1, 4 + 2 m) of
    a plan of shape (K, m)."""
    K, m = torque.shape
    N = min(length for length in arcs if length >= K)
    U, h = np.zeros((m, N)), np.zeros(N)
    U[:, :K], h[:K] = torque.T, period
    out = arcs[N](x0, U, h, model.J_hub_inverse, model.h_N, goal)
    end, slope, x = (np.array(part) for part in out)
    return end.ravel(), slope[:, : K * m], np.vstack([x0, x[:, :K].T])


def _interval(spacecraft: Spacecraft, network: AppendageNetwork | None) -> Any:
    """CasADi function (x, u, h, (J_hub^-1, h_N)) -> x after one interval."""
    m = spacecraft.wheels
    q, p, previous, u = (ca.SX.sym(name, n) for name, n in zip("qpvu", (4, m, m, m), strict=True))
    c, c_before, before = ca.SX.sym("c", 3), ca.SX.sym("d", 3), ca.SX.sym("w", m)
    h, shared = ca.SX.sym("h"), ca.SX.sym("shared", 12)
    inverse, h_N = ca.reshape(shared[:9], 3, 3), shared[9:]
    lasts = ca.if_else(h > 0.0, 1.0, 0.0)
    change = lasts * (u - previous)
    ramp = ca.fabs(change) / ca.DM(spacecraft.torque_rate_max)
    safe = h + (1.0 - lasts)
    p_next = p + h * u - change * ramp / 2.0
    p_mean = p + h * u / 2.0 - change * (ramp / 2.0 - ramp**2 / (6.0 * safe))
    A = ca.DM(spacecraft.A)
    carried, carried_mean, carried_next = A @ p, A @ p_mean, A @ p_next
    x, x_next = [q, p, previous], [p_next, lasts * u + (1.0 - lasts) * previous]
    if network is not None:
        c_next, c_mean = symbolic(network, c, c_before, u, previous, before, p_mean)
        carried, carried_mean, carried_next = (
            carried + c,
            carried_mean + c_mean,
            carried_next + c_next,
        )
        x += [c, c_before, before]
        moved = (c_next, c, previous)
        x_next += [lasts * new + (1.0 - lasts) * old for new, old in zip(moved, x[3:], strict=True)]
    q_half = _turned(q, h / 2.0 * (inverse @ (in_body(q, h_N) - carried)))
    rate = inverse @ (in_body(q_half, h_N) - carried_mean)
    theta = h * rate + h * h / 12.0 * ca.cross(rate, inverse @ (carried - carried_next))
    x_next.insert(0, _turned(q, theta))
    inputs = [ca.vertcat(*x), u, h, shared]
    return ca.Function("interval", inputs, [ca.vertcat(*x_next)])


def in_body(q: Symbol, v_N: Symbol) -> Symbol:
    """R(q)' v_N."""
    t = 2.0 * ca.cross(q[1:], v_N)
    return v_N - q[0] * t + ca.cross(q[1:], t)


def vector_from(q: Symbol, goal: Symbol) -> Symbol:
    """Vector part of goal^-1 (x) q, on the short way round."""
    scalar = ca.dot(goal, q)
    vector = goal[0] * q[1:] - q[0] * goal[1:] - ca.cross(goal[1:], q[1:])
    return vector * ca.sign(scalar)


def _turned(q: Symbol, theta: Symbol) -> Symbol:
    """q (x) exp(theta / 2); series of cos and sinc, good to 1e-9 below 1 rad, smooth at zero."""
    s = ca.dot(theta, theta) / 4.0
    cosine = 1.0 - s / 2.0 * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0)))
    sinc = 1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)))
    v = 0.5 * sinc * theta
    return ca.vertcat(
        q[0] * cosine - ca.dot(q[1:], v), q[0] * v + cosine * q[1:] + ca.cross(q[1:], v)
    )
