"""The minimum-time slew to rest in the goal: free end time, multiple shooting, IPOPT.

    minimise T + 1e-4 mean |u / u_max|^2   subject to the momentum form, |u| <= u_max, |p| <= p_max,
    q(T) = goal,  B'(A p(T) - R'h_N) = 0

over N equal intervals (RK4 each; 20 of them lengthen it by 0.2 % against 60). In momentum form
this is so smooth that it solves in about 15 iterations (10 ms) and nearly every guess finds the
same optimum; attitudes close to a turn about the unactuated axis have local ones, hence several
guesses. Torque ramps are left out; `terminal` has them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ...ground.arrays import Array, Quaternion, Symbol, WheelVector
from ...ground.attitude import error_angle
from ...ground.spacecraft import Spacecraft
from ...model.momentum import MomentumModel, actuated_basis
from ...model.rotation import in_body, rotation_rate, vector_from

EFFORT = 1e-4  # s: picks one of the controls where the time alone leaves a choice
MAX_ITERATIONS = 50
TOLERANCE = 1e-5  # IPOPT's: the terminal problem makes the end exact
SHORTEST, LONGEST = 0.1, 10.0  # bounds of the duration, of what is expected
SPEED_SHARE = 0.97  # of the speed limit: the body's own rate takes part of the rest
NO_LIMIT = 1e6  # stands for a wheel speed without limit, in units of the torque limit times 1 s
FIRST_WIDTH, WIDTH = 0.1, 1.0  # size of the first and of all later random guesses


@dataclass(frozen=True)
class MinimumTime:
    """The problem for one spacecraft: `build_minimum_time` makes it, `solve_minimum_time` solves
    it for some boundary values."""

    spacecraft: Spacecraft
    intervals: int
    solver: Any


@dataclass(frozen=True)
class BoundaryValues:
    """Where a slew begins and ends."""

    q: Quaternion
    """Attitude at its start."""
    p: WheelVector
    """Spin momenta at its start, Nms."""
    goal: Quaternion
    torque_max: WheelVector
    """Nm."""


@dataclass(frozen=True)
class MinimumTimeSlew:
    """A solution."""

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


def build_minimum_time(spacecraft: Spacecraft, intervals: int = 20) -> MinimumTime:
    """The problem with so many intervals; every number but the wheels is a run-time parameter."""
    m, N = spacecraft.wheels, intervals
    inverse, h_N, goal = ca.SX.sym("Ji", 3, 3), ca.SX.sym("h_N", 3), ca.SX.sym("goal", 4)
    scale = ca.SX.sym("scale", m)
    X, U, T = ca.SX.sym("X", 4 + m, N + 1), ca.SX.sym("U", m, N), ca.SX.sym("T")
    A = ca.DM(spacecraft.A)

    def derivative(x: Symbol, u: Symbol) -> Symbol:
        q, p = x[:4], x[4:]
        return ca.vertcat(rotation_rate(q, inverse @ (in_body(q, h_N) - A @ p)), u)

    gaps = [_gap(derivative, X[:, k], U[:, k], X[:, k + 1], T / N) for k in range(N)]
    q, p = X[:4, N], X[4:, N]
    rest = ca.DM(actuated_basis(spacecraft).T) @ (A @ p - in_body(q, h_N))
    effort = ca.sumsqr(U / ca.repmat(scale, 1, N)) / N
    problem = {
        "x": ca.vertcat(ca.vec(X), ca.vec(U), T),
        "p": ca.vertcat(ca.vec(inverse), h_N, goal, scale),
        "f": T + EFFORT * effort,
        "g": ca.vertcat(*gaps, vector_from(q, goal), rest),
    }
    ipopt: Any = {"print_level": 0, "sb": "yes", "max_iter": MAX_ITERATIONS, "tol": TOLERANCE}
    solver = ca.nlpsol("minimum_time", "ipopt", problem, {"ipopt": ipopt, "print_time": False})
    return MinimumTime(spacecraft, N, solver)


def _gap(
    derivative: Callable[[Symbol, Symbol], Symbol], x: Symbol, u: Symbol, x_next: Symbol, h: Symbol
) -> Symbol:
    """What one Runge-Kutta step from x leaves to x_next."""
    k1 = derivative(x, u)
    k2 = derivative(x + h / 2.0 * k1, u)
    k3 = derivative(x + h / 2.0 * k2, u)
    k4 = derivative(x + h * k3, u)
    return x_next - x - h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def solve_minimum_time(
    problem: MinimumTime, model: MomentumModel, values: BoundaryValues, guess: int
) -> MinimumTimeSlew | None:
    """The shortest slew, or None if none was found.

    `guess` (0, 1, ...) numbers the first guesses: a straight turn with random wheel momenta, small
    for the first and large for the others. The same number is always the same guess.
    """
    N, m = problem.intervals, problem.spacecraft.wheels
    torque_max, goal = values.torque_max, values.goal
    goal = goal if goal @ values.q >= 0.0 else -goal
    duration = expected_duration(model, values.q, goal, torque_max)
    X, U = _guess(values, goal, duration, N, guess)
    lower, upper = _state_bounds(problem, values)
    limit = np.tile(torque_max, N)
    solution = problem.solver(
        x0=np.concatenate([X.ravel("F"), U.ravel("F"), [duration]]),
        lbx=np.concatenate([lower.ravel("F"), -limit, [SHORTEST * duration]]),
        ubx=np.concatenate([upper.ravel("F"), limit, [LONGEST * duration]]),
        lbg=0.0,
        ubg=0.0,
        p=np.concatenate([model.J_hub_inverse.ravel("F"), model.h_N, goal, torque_max]),
    )
    stats = problem.solver.stats()
    if not stats["success"]:
        return None
    z = np.array(solution["x"]).ravel()
    torque = z[X.size : -1].reshape(N, m)
    return MinimumTimeSlew(float(z[-1]), torque, int(stats["iter_count"]))


def _state_bounds(problem: MinimumTime, values: BoundaryValues) -> tuple[Array, Array]:
    """Of the states (4 + m, N + 1): the first is given, later wheels keep to their limits."""
    columns = problem.intervals + 1
    p_max = np.maximum(momentum_limit(problem.spacecraft, values.torque_max), np.abs(values.p))
    bound = np.vstack([np.full((4, columns), np.inf), np.repeat(p_max[:, None], columns, 1)])
    lower, upper = -bound, bound
    lower[:, 0] = upper[:, 0] = np.concatenate([values.q, values.p])
    return lower, upper


def expected_duration(
    model: MomentumModel, q: Quaternion, goal: Quaternion, torque_max: WheelVector
) -> float:
    """A rough duration, s: of turning phi from rest to rest, and of one loop that encloses phi."""
    turn = float(error_angle(q, goal))
    pace = np.sqrt(np.trace(model.J) / 3.0 / np.min(torque_max))
    return float(pace * (1.5 * np.sqrt(turn) + 1.5 * turn**0.25) + 1.0)


def momentum_limit(spacecraft: Spacecraft, torque_max: WheelVector) -> WheelVector:
    """Spin momentum just inside the speed limit, Nms."""
    return np.where(
        np.isfinite(spacecraft.speed_max),
        SPEED_SHARE * spacecraft.Js * spacecraft.speed_max,
        NO_LIMIT * torque_max,
    )


def _guess(
    values: BoundaryValues, goal: Quaternion, duration: float, N: int, number: int
) -> tuple[Array, Array]:
    """States (4 + m, N + 1) and torques (m, N) of a straight turn with random wheel momenta."""
    q, p = values.q, values.p
    t = np.arange(N + 1) / N
    attitude = np.outer(q, 1.0 - t) + np.outer(goal, t)
    attitude /= np.linalg.norm(attitude, axis=0)
    width = FIRST_WIDTH if number == 0 else WIDTH
    size = width * duration / 6.0 * values.torque_max
    waves = np.array([np.sin(np.pi * k * t) for k in (1, 2, 3)])
    shape = np.random.default_rng(number).normal(size=(len(p), 3)) @ waves
    momentum = np.outer(p, 1.0 - t) + size[:, None] * shape
    return np.vstack([attitude, momentum]), np.diff(momentum, axis=1) * N / duration
