"""The shortest manoeuvre to rest in the goal: free end time, multiple shooting, IPOPT.

    minimise T + 1e-4 mean |u / u_max|^2   subject to the momentum form, |u| <= u_max, |p| <= p_max,
    q(T) = goal,  B'(A p(T) - R'h_N) = 0

over N equal intervals (RK4 each; 20 of them lengthen it by 0.2 % against 60). In momentum form
this is so smooth that it solves in about 15 iterations (10 ms) and nearly every start finds the
same optimum; attitudes close to a turn about the unactuated axis have local ones, hence several
starts. Torque ramps are left out; `steering` has them.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ...ground.arrays import Array, Quaternion, WheelVector
from ...ground.attitude import error_angle
from ...ground.spacecraft import Spacecraft
from ...model.momentum import MomentumModel, actuated_basis
from .arc import in_body, vector_from

EFFORT = 1e-4  # s: picks one of the controls where the time alone leaves a choice
MAX_ITERATIONS = 50
FIRST_WIDTH, WIDTH = 0.1, 1.0  # size of the first and of all later random starts
NO_LIMIT = 1e6  # stands for a wheel speed without limit, in units of the torque limit times 1 s


@dataclass(frozen=True)
class FreeTime:
    """The problem for one spacecraft: `build_free_time` makes it, `solve_free_time` solves it."""

    spacecraft: Spacecraft
    intervals: int
    solver: Any


@dataclass(frozen=True)
class Manoeuvre:
    """A shortest manoeuvre."""

    duration: float
    """s"""
    torque: Array
    """Torque the rotors keep over each interval, Nm, shape (N, m)."""
    iterations: int

    def on_grid(self, periods: int, period: float) -> Array:
        """Mean torque over each of so many periods, after stretching the time to fill them with
        the same impulses, shape (periods, m)."""
        knots = np.linspace(0.0, periods * period, len(self.torque) + 1)
        impulse = np.vstack([0.0 * self.torque[:1], np.cumsum(self.torque, axis=0)])
        at = np.arange(periods + 1) * period
        step = self.duration / len(self.torque)
        columns = [np.interp(at, knots, step * column) for column in impulse.T]
        return np.diff(np.column_stack(columns), axis=0) / period


def build_free_time(spacecraft: Spacecraft, intervals: int = 20) -> FreeTime:
    """The problem with so many intervals; every number but the wheels is a run-time parameter."""
    m, N = spacecraft.wheels, intervals
    inverse, h_N, goal = ca.SX.sym("Ji", 3, 3), ca.SX.sym("h_N", 3), ca.SX.sym("goal", 4)
    scale = ca.SX.sym("scale", m)
    X, U, T = ca.SX.sym("X", 4 + m, N + 1), ca.SX.sym("U", m, N), ca.SX.sym("T")
    A = ca.DM(spacecraft.A)

    def derivative(x: Any, u: Any) -> Any:
        q, p = x[:4], x[4:]
        w = inverse @ (in_body(q, h_N) - A @ p)
        turn = ca.vertcat(-ca.dot(q[1:], w), q[0] * w + ca.cross(q[1:], w))
        return ca.vertcat(turn / 2.0, u)

    gaps = []
    for k in range(N):
        x, u, h = X[:, k], U[:, k], T / N
        k1 = derivative(x, u)
        k2 = derivative(x + h / 2.0 * k1, u)
        k3 = derivative(x + h / 2.0 * k2, u)
        k4 = derivative(x + h * k3, u)
        gaps.append(X[:, k + 1] - x - h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
    q, p = X[:4, N], X[4:, N]
    rest = ca.DM(actuated_basis(spacecraft).T) @ (A @ p - in_body(q, h_N))
    effort = ca.sumsqr(U / ca.repmat(scale, 1, N)) / N
    problem = {
        "x": ca.vertcat(ca.vec(X), ca.vec(U), T),
        "p": ca.vertcat(ca.vec(inverse), h_N, goal, scale),
        "f": T + EFFORT * effort,
        "g": ca.vertcat(*gaps, vector_from(q, goal), rest),
    }
    ipopt: Any = {"print_level": 0, "sb": "yes", "max_iter": MAX_ITERATIONS, "tol": 1e-5}
    solver = ca.nlpsol("free_time", "ipopt", problem, {"ipopt": ipopt, "print_time": False})
    return FreeTime(spacecraft, N, solver)


def solve_free_time(
    problem: FreeTime,
    model: MomentumModel,
    q: Quaternion,
    p: WheelVector,
    goal: Quaternion,
    torque_max: WheelVector,
    start: int,
) -> Manoeuvre | None:
    """The shortest manoeuvre from attitude q and spin momenta p, or None if none was found.

    `start` (0, 1, ...) numbers the first guesses: a straight turn with random wheel momenta, small
    for the first and large for the others. The same number is always the same guess.
    """
    N, m = problem.intervals, problem.spacecraft.wheels
    goal = goal if goal @ q >= 0.0 else -goal
    duration = expected_duration(model, q, goal, torque_max)
    X, U = _guess(q, p, goal, torque_max, duration, N, start)
    momentum_max = np.maximum(momentum_limit(problem.spacecraft, torque_max), np.abs(p))
    bound = np.vstack([np.full((4, N + 1), np.inf), np.repeat(momentum_max[:, None], N + 1, 1)])
    lower, upper = -bound, bound
    lower[:, 0] = upper[:, 0] = np.concatenate([q, p])
    flat = [part.ravel("F") for part in (X, U)]
    limit = np.tile(torque_max, N)
    solution = problem.solver(
        x0=np.concatenate([*flat, [duration]]),
        lbx=np.concatenate([lower.ravel("F"), -limit, [0.1 * duration]]),
        ubx=np.concatenate([upper.ravel("F"), limit, [10.0 * duration]]),
        lbg=0.0,
        ubg=0.0,
        p=np.concatenate([model.J_hub_inverse.ravel("F"), model.h_N, goal, torque_max]),
    )
    stats = problem.solver.stats()
    if not stats["success"]:
        return None
    z = np.array(solution["x"]).ravel()
    torque = z[X.size : -1].reshape(N, m)
    return Manoeuvre(float(z[-1]), torque, int(stats["iter_count"]))


def expected_duration(
    model: MomentumModel, q: Quaternion, goal: Quaternion, torque_max: WheelVector
) -> float:
    """A rough duration, s: of turning phi from rest to rest, and of one loop that encloses phi."""
    turn = float(error_angle(q, goal))
    pace = np.sqrt(np.trace(model.J) / 3.0 / np.min(torque_max))
    return float(pace * (1.5 * np.sqrt(turn) + 1.5 * turn**0.25) + 1.0)


def momentum_limit(spacecraft: Spacecraft, torque_max: WheelVector) -> WheelVector:
    """Spin momentum at 97 % of the speed limit: the body's own rate takes part of the rest."""
    return np.where(
        np.isfinite(spacecraft.speed_max),
        0.97 * spacecraft.Js * spacecraft.speed_max,
        NO_LIMIT * torque_max,
    )


def _guess(
    q: Quaternion,
    p: WheelVector,
    goal: Quaternion,
    torque_max: WheelVector,
    duration: float,
    N: int,
    start: int,
) -> tuple[Array, Array]:
    """States (4 + m, N + 1) and torques (m, N) of a straight turn with random wheel momenta."""
    t = np.arange(N + 1) / N
    attitude = np.outer(q, 1.0 - t) + np.outer(goal, t)
    attitude /= np.linalg.norm(attitude, axis=0)
    width = FIRST_WIDTH if start == 0 else WIDTH
    size = width * duration / 6.0 * torque_max
    waves = np.array([np.sin(np.pi * k * t) for k in (1, 2, 3)])
    shape = np.random.default_rng(start).normal(size=(len(p), 3)) @ waves
    momentum = np.outer(p, 1.0 - t) + size[:, None] * shape
    return np.vstack([attitude, momentum]), np.diff(momentum, axis=1) * N / duration
