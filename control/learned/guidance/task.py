"""What all phases of the guidance share: the target, the settings, and the arrival they aim at."""

from dataclasses import dataclass, replace

import numpy as np

from ...ground.arrays import Array, Quaternion, Vector3
from ...ground.attitude import error_angle, error_quaternion, multiply, rotation_matrix
from ...model.momentum import MomentumModel
from ...model.reachable import nearest_rest
from ...reference.reference import Reference
from ..prediction.state import PlanningState
from ..settings import FEWEST_HOLD_PERIODS, LearnedSettings
from .drift import predicted_drift, unactuated_rate
from .minimum_time import MinimumTime, momentum_limit
from .terminal import TerminalConditions, TerminalProblem, TerminalSolution, solve_terminal
from .trajectory import Trajectory

ACCEPTED = 5e-4  # rad, rad/s: a larger terminal error (0.03 deg) takes another period
PATIENCE = 12  # Newton steps with more periods than the guess had; half as many otherwise
BIAS_SHARE = 2.0 / 3.0  # of the drift to come, by which the arrival is biased: see `drift`
DRIFT_TIME = 80.0  # s: the hold that is prepared for by default
HOLD_TIME = 3.0  # s, in which a hold takes out an error
BIAS_BOUND = 0.8  # of the re-arming error: how far off the arrival may be biased


@dataclass(frozen=True, eq=False)
class GuidanceTask:
    """One target and one spacecraft: settings and prepared problems, no state."""

    settings: LearnedSettings
    target: Quaternion
    period: float
    """Control period, s."""
    minimum_time: MinimumTime
    reference: Reference | None = None
    """What moves, and has the target's place; None rests at the target."""
    now: float = 0.0
    """Time at which the reference is at the target, s."""

    def at(self, t: float) -> "GuidanceTask":
        """The task at time t (s)."""
        if self.reference is None:
            return self
        return replace(self, target=self.reference.attitude(t), now=t)

    def aimed(self, model: MomentumModel) -> "GuidanceTask":
        """The task with the target, or with the attitude nearest to it where the momentum, as it is
        believed to be, lets the craft rest, if a hold at the target would drift as far as that."""
        if self.reference is not None:
            return self
        rest = nearest_rest(model.spacecraft, self.target, model.h_N)
        if rest is None:
            return self
        drift = unactuated_rate(model, self.target) * DRIFT_TIME
        return self if abs(drift) < error_angle(rest, self.target) else replace(self, target=rest)

    def then(self, goal: Quaternion, seconds: float) -> tuple[Quaternion, Vector3 | None]:
        """A goal beside the target as it is now, moved on with the reference by so many seconds,
        and its rate (rad/s, its own axes)."""
        if self.reference is None:
            return goal, None
        t = self.now + seconds
        beside = error_quaternion(goal, self.target)
        rate = rotation_matrix(beside).T @ self.reference.rate(t)
        return multiply(self.reference.attitude(t), beside), rate

    def periods(self, seconds: float) -> int:
        """Control periods that so many seconds are about, at least one."""
        return max(1, round(seconds / self.period))

    @property
    def hold_periods(self) -> int:
        """Control periods in which the hold takes out an error."""
        given = self.settings.hold_periods
        return max(FEWEST_HOLD_PERIODS, self.periods(HOLD_TIME)) if given is None else given

    def bias(self, trajectory: Trajectory, state: PlanningState) -> float:
        """Minus the share of the drift to come, as far as it can be relied upon, rad."""
        hold = self.settings.hold
        delay = len(trajectory.torque) * self.period
        drift = predicted_drift(state.model, state.estimate, self.target, delay, hold)
        bound = BIAS_BOUND * np.deg2rad(self.settings.rearm_deg)
        return float(np.clip(-BIAS_SHARE * state.estimate.torque_confidence * drift, -bound, bound))

    def solve(
        self,
        state: PlanningState,
        goal: Quaternion,
        guess: Array,
        conditions: TerminalConditions,
        iterations: int,
    ) -> TerminalSolution:
        """The plan from here that ends in the goal, wherever that is by then, from a guess of shape
        (K, m)."""
        goal, rate = self.then(goal, len(guess) * self.period)
        problem = TerminalProblem(
            state.propagator,
            state.model,
            state.x0,
            goal,
            state.torque_max,
            self.period,
            conditions,
            rate,
        )
        return solve_terminal(problem, guess, iterations)


def too_fast(state: PlanningState, solution: TerminalSolution) -> bool:
    """Whether a wheel would pass its speed limit, and go further beyond it than now."""
    m = len(state.p)
    limit = momentum_limit(state.model.spacecraft, state.torque_max)
    limit = np.maximum(limit, np.abs(state.p))
    return bool(np.any(np.abs(solution.x[:, 4 : 4 + m]) > limit + 1e-9))


def lengthened(torque: Array, periods: int) -> Array:
    """The plan with so many periods more, without torque."""
    return np.vstack([torque, np.zeros((periods, torque.shape[1]))])
