"""The baseline planner: nonlinear MPC of attitude, rates and wheel speeds, as in the paper.

Every period it solves, from the measured state x_0 = (q_BT, omega, Omega, u_prev), the problem of
`ocp.py` with the prediction model of `dynamics.py` and the cost of `cost.py`, and commands the
first input. Limits on torque (and on its change, where the rate limit can bind) are hard; limits
on wheel speed and body rate are soft, so that a start outside them is steered back inside.
"""

import pickle
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import lru_cache
from typing import Annotated

import numpy as np

from ..ground.arrays import Array, Quaternion, Vector3, WheelVector
from ..ground.attitude import error_quaternion, rotation_matrix
from ..ground.own import Own, own
from ..ground.settings import Bounds, Positive, Settings
from ..ground.spacecraft import Spacecraft
from ..ground.units import Units
from ..interface.blind import BlindStatus, no_torque
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from ..model.reachable import nearest_rest
from ..solver import (
    Solution,
    SolverSettings,
    SolverStatus,
    roll_out,
    solve_ocp,
    solver_of,
)
from ..solver.ocp import Limits, Ocp, join_limits, no_limits
from .cost import Weights
from .guess import Guess, shapes, shifted
from .problem import attitude_stage

SOFTNESS = 100.0  # cost of exceeding a soft limit by its own size: more than any slew is worth
HORIZON_MAX = 500  # some 50 natural times: longer than any slew, and every plan pays for it
SLOWEST_DEG_S = 1e-6  # a turn in ten years; below, rows in units of the limit lose all digits
SADDLE_ERROR = np.deg2rad(0.5)  # beyond this a plan that does (nearly) nothing is not believed
SADDLE_TORQUE = 0.02  # of the torque limit: what "nearly nothing" means
WORTHWHILE = 1e-6  # of the cost: what a second solution must save to be flown


@dataclass(frozen=True)
class NmpcSettings(Settings, group="nmpc"):
    """The planner's problem."""

    period: Annotated[Positive | None, Own("time", 0.5)] = None
    """Time between plans, and the length of a stage, s; 0.5 of the craft's own seconds unless
    given."""
    horizon: Annotated[int, Bounds(1, HORIZON_MAX)] = 24
    """Stages looked ahead; 24 of 0.5 own seconds see 2.2 natural times, 12 s of the benchmark."""
    weights: Weights = field(default_factory=Weights)
    keep_rate_below_deg_s: Annotated[
        Annotated[float, Bounds(SLOWEST_DEG_S)] | None, Own("rate")
    ] = None
    """Soft limit on each component of the body rate, deg/s; none unless given."""
    friction: bool = False
    """Put the model file's wheel friction into the prediction."""
    solver: SolverSettings = field(default_factory=SolverSettings)

    @property
    def stage(self) -> float:
        """Length of a control period and of a stage."""
        return own(self, "period")


class PlanStatus(StrEnum):
    """Where a command came from, as a sentence."""

    OPTIMAL = "The planner found an optimum."
    NEAREST_REST = "The momentum allows no rest at the target; the craft makes for the nearest one."
    UNFINISHED = "The solver used all its iterations; its best plan is flown."
    SHIFTED = "The solver failed; the previous plan is flown on."
    DAMPING = "The solver failed and no plan is left; the wheels damp the body rate."


@dataclass(frozen=True)
class Memory:
    """What one plan hands to the next."""

    torque: Array
    """The plan, shape (N, m)."""
    periods_left: int
    """How many of its inputs may still be flown if the solver fails."""
    rest: Quaternion | None = None
    """The attitude it makes for, where the momentum allows none at the target (`reachable`)."""

    def flown_on(self) -> "Memory":
        """The memory after a period in which the plan was followed without another."""
        return Memory(shifted(self.torque), self.periods_left - 1, self.rest)


@dataclass(frozen=True)
class Optimum:
    """The evidence of a plan: the solution whose first input is commanded."""

    solution: Solution
    guess: Guess
    """The guess that led to it."""

    def in_units(self, units: Units) -> "Optimum":
        """Inputs and states in other units; what the solver says of its work stays as it was."""
        u, x = self.solution.u, self.solution.x
        m = u.shape[1]
        state = np.repeat([1.0, units.rate, units.rate, units.torque], (4, 3, m, m))
        solution = replace(self.solution, u=u / units.torque, x=x / state)
        return Optimum(solution, self.guess)


@dataclass(frozen=True, eq=False)
class Nmpc:
    """A spacecraft's planner: `build_nmpc` makes it, `plan` asks it."""

    spacecraft: Spacecraft
    settings: NmpcSettings
    target: Quaternion
    """Attitude to reach, target -> inertial."""
    ocp: Ocp
    torque_scale: WheelVector
    """Torque limit, or its stand-in where there is none, Nm."""

    def plan(
        self, measurement: Measurement, memory: Memory | None, residual: Vector3 | float = 0.0
    ) -> tuple[Plan, Memory | None]:
        """Command for the coming period; `residual` is tau_d, body axes, Nm, held over the
        horizon."""
        rest = self._rest(measurement) if memory is None else memory.rest
        x0 = self.state(measurement, rest)
        p = np.broadcast_to(np.asarray(residual, float), (3,))
        solution, guess = self._solve(x0, p, memory)
        if solution.status is SolverStatus.FAILED:
            return self._fall_back(measurement, memory)
        status = PlanStatus.OPTIMAL if rest is None else PlanStatus.NEAREST_REST
        if solution.status is SolverStatus.ITERATION_LIMIT:
            status = PlanStatus.UNFINISHED
        torque = np.clip(solution.u[0], -self.spacecraft.torque_max, self.spacecraft.torque_max)
        plan = Plan(torque, status, evidence=Optimum(solution, guess))
        return plan, Memory(shifted(solution.u), self.settings.horizon - 1, rest)

    def fly_on(self, torque: WheelVector, memory: Memory | None) -> tuple[Plan, Memory | None]:
        """The previous plan without a measurement, while it lasts; then no torque, and the next
        measurement is planned from as the first was."""
        if memory is None or memory.periods_left == 0:
            return no_torque(self.spacecraft.wheels), None
        return Plan(memory.torque[0], BlindStatus.FLOWN_ON), memory.flown_on()

    def state(self, measurement: Measurement, rest: Quaternion | None = None) -> Array:
        """x_0 = (q_BT, omega, Omega, u_prev) of a measurement, T being the rest, if one is given,
        else the target."""
        previous = np.clip(measurement.torque, -self.torque_scale, self.torque_scale)
        target = self.target if rest is None else rest
        error = _one_sided(error_quaternion(measurement.q, target))
        return np.concatenate([error, measurement.omega, measurement.wheel_speed, previous])

    def _rest(self, measurement: Measurement) -> Quaternion | None:
        """Decided once, at the start: the believed momentum is most nearly true at low rates."""
        H_B = self.spacecraft.angular_momentum(measurement.omega, measurement.wheel_speed)
        H_N = rotation_matrix(measurement.q) @ H_B
        return nearest_rest(self.spacecraft, self.target, H_N)

    def _solve(self, x0: Array, p: Array, memory: Memory | None) -> tuple[Solution, Guess]:
        """From the previous plan or none; near a saddle also from the most promising shape."""
        start = np.zeros((self.ocp.N, self.ocp.nu)) if memory is None else memory.torque
        first = Guess.COAST if memory is None else Guess.PREVIOUS
        solution = solve_ocp(self.ocp, x0, start, p, self.settings.solver)
        if memory is not None and not self._doubtful(x0, solution):
            return solution, first
        second = self._promising_shape(x0, p)
        other = solve_ocp(self.ocp, x0, second[1], p, self.settings.solver)
        failed = solution.status is SolverStatus.FAILED
        if failed or other.objective < (1.0 - WORTHWHILE) * solution.objective:
            return other, second[0]
        return solution, first

    def _doubtful(self, x0: Array, solution: Solution) -> bool:
        """Whether the solution hardly moves although the target is not reached."""
        error = 2.0 * np.linalg.norm(x0[1:4])
        idle = np.max(np.abs(solution.u) / self.torque_scale) < SADDLE_TORQUE
        return bool((idle and error > SADDLE_ERROR) or solution.status is SolverStatus.FAILED)

    def _promising_shape(self, x0: Array, p: Array) -> tuple[Guess, Array]:
        """The shape whose roll-out is cheapest."""
        guesses = shapes(
            self.spacecraft, self.torque_scale, x0[:4], self.ocp.N, self.settings.stage
        )
        return min(
            guesses.items(),
            key=lambda item: roll_out(self.ocp, x0, item[1], p, self.settings.solver)[1],
        )

    def _fall_back(
        self, measurement: Measurement, memory: Memory | None
    ) -> tuple[Plan, Memory | None]:
        """The previous plan while it lasts, then the damping law."""
        if memory is not None and memory.periods_left > 0:
            plan = Plan(memory.torque[0], PlanStatus.SHIFTED, failed=True)
            return plan, memory.flown_on()
        torque = damping_torque(self.spacecraft, measurement, self.settings.stage)
        return Plan(torque, PlanStatus.DAMPING, failed=True), None


def build_nmpc(spacecraft: Spacecraft, settings: NmpcSettings, target: Quaternion) -> Nmpc:
    """The planner of a spacecraft as the controller believes it to be, ready to plan at once."""
    ocp = _built_once(pickle.dumps((spacecraft, settings)))
    solver_of(ocp, settings.solver.backend)
    scale = torque_scale(spacecraft, settings)
    return Nmpc(spacecraft, settings, np.asarray(target, float), ocp, scale)


@lru_cache(maxsize=8)
def _built_once(recipe: bytes) -> Ocp:
    """The problem of a pickled (spacecraft, settings): a campaign asks for the same one each run,
    and arrays have no hash."""
    spacecraft, settings = pickle.loads(recipe)
    return build_attitude_ocp(spacecraft, settings)


def build_attitude_ocp(spacecraft: Spacecraft, settings: NmpcSettings) -> Ocp:
    """The paper's optimal control problem, x = (q_BT, omega, Omega, u_prev), p = tau_d."""
    scale = torque_scale(spacecraft, settings)
    stage, coefficients = attitude_stage(
        spacecraft, settings.weights, settings.stage, scale, settings.friction
    )
    return Ocp(stage, coefficients, attitude_limits(spacecraft, settings), settings.horizon)


def attitude_limits(spacecraft: Spacecraft, settings: NmpcSettings) -> Limits:
    """Rows for torque, torque rate, wheel speed and body rate, each in units of its limit."""
    m = spacecraft.wheels
    nx = 7 + 2 * m
    eye = np.eye(m)
    speed, previous = np.zeros((m, nx)), np.zeros((m, nx))
    speed[:, 7 : 7 + m], previous[:, 7 + m :] = eye, eye
    none = np.zeros((m, m))
    step = spacecraft.torque_rate_max * settings.stage
    step = np.where(step < 2.0 * spacecraft.torque_max, step, np.inf)
    parts = [
        _two_sided(0.0 * speed, eye, spacecraft.torque_max, np.inf),
        _two_sided(-previous, eye, step, np.inf),
        _two_sided(speed, none, spacecraft.speed_max, SOFTNESS),
    ]
    if settings.keep_rate_below_deg_s is not None:
        rate = np.zeros((3, nx))
        rate[:, 4:7] = np.eye(3)
        limit = np.full(3, np.deg2rad(settings.keep_rate_below_deg_s))
        parts.append(_two_sided(rate, np.zeros((3, m)), limit, SOFTNESS))
    return join_limits(no_limits(nx, m), *parts)


def _two_sided(Cx: Array, Cu: Array, limit: Array, softness: float) -> Limits:
    """|Cx x + Cu u| <= limit, divided by the limit; rows with an infinite limit are left out."""
    keep = np.isfinite(limit)
    scale = 1.0 / limit[keep, None]
    one = np.ones(int(keep.sum()))
    return Limits(scale * Cx[keep], scale * Cu[keep], -one, one, softness * one)


def torque_scale(spacecraft: Spacecraft, settings: NmpcSettings) -> WheelVector:
    """Torque limit of each wheel; where there is none, the torque that turns the largest inertia
    by a right angle, rest to rest, in half the horizon."""
    half = settings.horizon * settings.stage / 2.0
    stand_in = 4.0 * np.linalg.eigvalsh(spacecraft.J)[-1] * (np.pi / 2.0) / half**2
    return np.where(np.isfinite(spacecraft.torque_max), spacecraft.torque_max, stand_in)


def damping_torque(spacecraft: Spacecraft, measurement: Measurement, period: float) -> WheelVector:
    """u = A^+ J omega / (4 T): the wheels take up the body's momentum over about four periods,
    inside the torque limit and never past a wheel's speed limit."""
    omega = np.nan_to_num(measurement.omega)
    wanted = np.linalg.pinv(spacecraft.A) @ (spacecraft.J @ omega) / (4.0 * period)
    torque = np.clip(wanted, -spacecraft.torque_max, spacecraft.torque_max)
    speed = np.nan_to_num(measurement.wheel_speed)
    saturated = (np.abs(speed) >= spacecraft.speed_max) & (torque * speed > 0.0)
    return np.where(saturated, 0.0, torque)


def _one_sided(q: Quaternion) -> Quaternion:
    """q and -q made equal even at half a turn, where neither has the larger scalar part."""
    if q[0] != 0.0:
        return q
    return q * np.sign(q[np.flatnonzero(q)[0]]) if np.any(q) else q
