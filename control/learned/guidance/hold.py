"""The hold: arrival a few periods from now, every period anew: a linear feedback near the target.

phi_n is left alone: it drifts, as it must, until it is worth another slew.
"""

from dataclasses import replace

import numpy as np

from ..prediction.state import PlanningState
from .task import PATIENCE, GuidanceTask
from .terminal import TerminalConditions
from .trajectory import Phase, Trajectory, TrajectoryStatus


def hold(task: GuidanceTask, trajectory: Trajectory, state: PlanningState) -> Trajectory:
    """A few periods to rest at the target."""
    rest = np.zeros((task.hold_periods, state.torque_max.size))
    solution = task.solve(state, task.target, rest, TerminalConditions.ACTUATED, PATIENCE // 4)
    return replace(
        trajectory,
        phase=Phase.HOLD,
        overruns=0,
        torque=solution.torque,
        solution=solution,
        status=TrajectoryStatus.HOLD,
    )
