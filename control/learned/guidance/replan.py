"""Guidance: the trajectory to the target, re-planned every period.

Slew, arrival and hold follow each other. A hold gives way to a new slew when the pointing error is
worth it (`rearm_deg`); an arrival that missed gives way to one at once.
"""

from dataclasses import replace

import numpy as np

from ...ground.attitude import error_angle
from ..prediction.state import PlanningState
from .arrival import ARRIVAL_TIME, arrive, arrive_fully, missed
from .hold import hold
from .slew import slew
from .task import GuidanceTask
from .trajectory import Phase, Trajectory


def unplanned(task: GuidanceTask, wheels: int, searches: int = 0) -> Trajectory:
    """A slew that is still to be sought, from other guesses than the searches made before."""
    torque = np.zeros((0, wheels))
    return Trajectory(Phase.SLEW, torque, task.settings.search_plans, searches)


def replan(task: GuidanceTask, trajectory: Trajectory, state: PlanningState) -> Trajectory | None:
    """The trajectory one period later, solved anew from here; None if none was found."""
    waited = max(trajectory.search_in - 1, 0)
    trajectory = replace(trajectory, torque=trajectory.torque[1:], search_in=waited)
    if trajectory.phase is Phase.HOLD:
        if error_angle(state.q, task.target) < np.deg2rad(task.settings.rearm_deg):
            return hold(task, trajectory, state)
        trajectory = _restarted(task, trajectory)
    elif missed(task, trajectory, state):
        trajectory = replace(_restarted(task, trajectory), repeated=True)
    fully = arrive_fully(task, trajectory, state)
    if fully is not None:
        return fully
    if trajectory.phase is Phase.SLEW:
        slewing = slew(task, trajectory, state)
        if slewing is None or len(slewing.torque) > task.periods(ARRIVAL_TIME):
            return slewing
        trajectory = slewing
    if len(trajectory.torque) > 1:
        return arrive(task, trajectory, state)
    return hold(task, trajectory, state)


def _restarted(task: GuidanceTask, trajectory: Trajectory) -> Trajectory:
    return unplanned(task, trajectory.torque.shape[1], trajectory.searches)
