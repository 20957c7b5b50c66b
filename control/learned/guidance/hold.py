"""The hold: arrival a few periods from now, every period anew: a linear feedback near the target.

phi_n is left alone: it drifts, as it must, until it is worth another slew. Not so with momentum in
the wheels' plane. Turned about the axis across it by theta, the craft has |H| theta of it along n,
which moves phi_n by |H| theta t / n'Jn: where that is of theta's size, all of the attitude is held.
"""

from dataclasses import replace

import numpy as np

from ..prediction.state import PlanningState
from .task import PATIENCE, GuidanceTask
from .terminal import TerminalConditions, TerminalSolution
from .trajectory import Phase, Trajectory, TrajectoryStatus

FULL_HOLD = 2.0  # times as long as a hold of the wheels' plane: the third axis follows the others
LEVERAGE = 0.25  # of a turn, that phi_n moves meanwhile: less costs more error than it takes out
ACCEPTED = 2e-3  # rad, rad/s: a larger error is left to the hold of the wheels' plane


def hold(task: GuidanceTask, trajectory: Trajectory, state: PlanningState) -> Trajectory:
    """A few periods to rest at the target."""
    solution = _full(task, state) or _actuated(task, state)
    return replace(
        trajectory,
        phase=Phase.HOLD,
        overruns=0,
        torque=solution.torque,
        solution=solution,
        status=TrajectoryStatus.HOLD,
    )


def _full(task: GuidanceTask, state: PlanningState) -> TerminalSolution | None:
    """All of the attitude taken to the target, where the momentum lends itself to it."""
    n, periods = state.model.spacecraft.unactuated, round(FULL_HOLD * task.hold_periods)
    if n is None:
        return None
    H = float(np.linalg.norm(state.model.h_N))
    leverage = H * periods * task.period / float(n @ state.model.J @ n)
    if leverage < LEVERAGE:
        return None
    rest = np.zeros((periods, state.torque_max.size))
    solution = task.solve(state, task.target, rest, TerminalConditions.FULL, PATIENCE // 2)
    return solution if solution.terminal_error < ACCEPTED else None


def _actuated(task: GuidanceTask, state: PlanningState) -> TerminalSolution:
    rest = np.zeros((task.hold_periods, state.torque_max.size))
    return task.solve(state, task.target, rest, TerminalConditions.ACTUATED, PATIENCE // 4)
