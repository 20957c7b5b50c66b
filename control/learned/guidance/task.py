"""What all phases of the guidance share: the target, the settings, and the arrival they aim at."""

from dataclasses import dataclass

import numpy as np

from ...ground.arrays import Array, Quaternion
from ..prediction.state import PlanningState
from ..settings import LearnedSettings
from .drift import predicted_drift
from .minimum_time import MinimumTime, momentum_limit
from .terminal import TerminalConditions, TerminalProblem, TerminalSolution, solve_terminal
from .trajectory import Trajectory

ACCEPTED = 5e-4  # rad, rad/s: a larger terminal error (0.03 deg) takes another period
PATIENCE = 12  # Newton steps with more periods than the guess had; half as many otherwise
BIAS_SHARE = 2.0 / 3.0  # of the drift to come, by which the arrival is biased: see `drift`
BIAS_BOUND = 0.8  # of the re-arming error: how far off the arrival may be biased


@dataclass(frozen=True, eq=False)
class GuidanceTask:
    """One target and one spacecraft: settings and prepared problems, no state."""

    settings: LearnedSettings
    target: Quaternion
    period: float
    """Control period, s."""
    minimum_time: MinimumTime

    def bias(self, trajectory: Trajectory, state: PlanningState) -> float:
        """Minus the share of the drift to come, as far as it can be relied upon, rad."""
        hold = self.settings.hold_s
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
        """The plan from here that ends in the goal, from a guess of shape (K, m)."""
        problem = TerminalProblem(
            state.propagator,
            state.model,
            state.x0,
            goal,
            state.torque_max,
            self.period,
            conditions,
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
