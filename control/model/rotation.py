"""Attitude algebra in CasADi: columns of SX or MX, conventions as in `ground.attitude`."""

import casadi as ca

from ..ground.arrays import Symbol


def rotation_rate(q: Symbol, omega: Symbol) -> Symbol:
    """q' = 1/2 q (x) (0, omega)."""
    vector = q[0] * omega + ca.cross(q[1:4], omega)
    return 0.5 * ca.vertcat(-ca.dot(q[1:4], omega), vector)


def in_body(q: Symbol, v_N: Symbol) -> Symbol:
    """R(q)' v_N."""
    t = 2.0 * ca.cross(q[1:], v_N)
    return v_N - q[0] * t + ca.cross(q[1:], t)


def vector_from(q: Symbol, goal: Symbol) -> Symbol:
    """Vector part of goal^-1 (x) q, on the short way round."""
    scalar = ca.dot(goal, q)
    vector = goal[0] * q[1:] - q[0] * goal[1:] - ca.cross(goal[1:], q[1:])
    return vector * ca.sign(scalar)
