"""The slew: the shortest way to rest in the arrival attitude, ended exactly.

K, the number of periods, comes from the minimum-time problem, sought from another guess each period
while the model is being learned, and counts down. The end is solved exactly each period, with a
period more when it can't be met.
"""

from dataclasses import replace

import numpy as np

from ...ground.arrays import Array, Quaternion
from ..prediction.state import PlanningState
from .arrival import arrive_early
from .drift import arrival_attitude
from .minimum_time import BoundaryValues, expected_duration, solve_minimum_time
from .task import ACCEPTED, PATIENCE, GuidanceTask, lengthened, too_fast
from .terminal import TerminalConditions, TerminalSolution, ramp_periods
from .trajectory import Trajectory, TrajectoryStatus

EXTRA_TIMES = (0.5, 1.0, 2.0)  # s, tried after a single period before the slew is sought anew
SEARCH_EVERY = 0.5  # s: in less hardly more is learned, and a search takes some 20 ms


def slew(task: GuidanceTask, trajectory: Trajectory, state: PlanningState) -> Trajectory | None:
    """The shorter of what is left of the old plan and what a search finds, ended exactly; None if
    there is neither."""
    bias = task.bias(trajectory, state)
    goal = arrival_attitude(state.model, task.target, bias)
    trajectory = replace(trajectory, bias=bias)
    due = trajectory.searches_left > 0 and trajectory.search_in == 0
    if due or len(trajectory.torque) == 0:
        trajectory = _sought(task, trajectory, state, goal)
    if len(trajectory.torque) == 0:
        return None
    return _ended(task, trajectory, state, goal)


def _sought(
    task: GuidanceTask, trajectory: Trajectory, state: PlanningState, goal: Quaternion
) -> Trajectory:
    """The trajectory after one more search."""
    found = _search(task, trajectory.searches, state, goal)
    return replace(
        trajectory,
        searches_left=trajectory.searches_left - 1,
        searches=trajectory.searches + 1,
        search_in=task.periods(SEARCH_EVERY),
        torque=_shorter(trajectory.torque, found),
    )


def _search(
    task: GuidanceTask, number: int, state: PlanningState, goal: Quaternion
) -> Array | None:
    """Torques of the shortest slew from guess `number`, on the control grid and with the last
    periods to rest in."""
    goal, _ = task.then(goal, expected_duration(state.model, state.q, goal, state.torque_max))
    values = BoundaryValues(state.q, state.p, goal, state.torque_max)
    best = solve_minimum_time(task.minimum_time, state.model, values, number)
    if best is None:
        return None
    periods = int(np.ceil((best.duration + task.settings.margin) / task.period))
    rest = ramp_periods(state.model.spacecraft, state.torque_max, task.period)
    return lengthened(best.on_grid(periods, task.period), rest)


def _shorter(old: Array, new: Array | None) -> Array:
    return old if new is None or 0 < len(old) <= len(new) else new


def _ended(
    task: GuidanceTask, trajectory: Trajectory, state: PlanningState, goal: Quaternion
) -> Trajectory:
    """The plan made to end in the goal, with as few periods more as that takes; or an arrival that
    leaves phi_n as it is, where that saves periods and is not worth a loop."""
    solution = _with_extra(task, trajectory, state, goal, 0)
    if solution.terminal_error < ACCEPTED:
        return _exact(trajectory, state, solution, stretched=False)
    early = arrive_early(task, trajectory, state, goal)
    if early is not None:
        return early
    for extra in sorted({1, *map(task.periods, EXTRA_TIMES)}):
        solution = _with_extra(task, trajectory, state, goal, extra)
        if solution.terminal_error < ACCEPTED:
            return _exact(trajectory, state, solution, stretched=True)
    # Too far off the plan: seek a new one next time, meanwhile fly the best there is.
    status = TrajectoryStatus.STRETCHED
    return replace(trajectory, torque=solution.torque, status=status, searches_left=1)


def _with_extra(
    task: GuidanceTask, trajectory: Trajectory, state: PlanningState, goal: Quaternion, extra: int
) -> TerminalSolution:
    guess = lengthened(trajectory.torque, extra)
    patience = PATIENCE if extra else PATIENCE // 2
    return task.solve(state, goal, guess, TerminalConditions.FULL, patience)


def _exact(
    trajectory: Trajectory, state: PlanningState, solution: TerminalSolution, stretched: bool
) -> Trajectory:
    if too_fast(state, solution):
        return _open_ended(trajectory)
    planned = TrajectoryStatus.REPEATED if trajectory.repeated else TrajectoryStatus.SLEW
    status = TrajectoryStatus.STRETCHED if stretched else planned
    return replace(trajectory, torque=solution.torque, solution=solution, status=status)


def _open_ended(trajectory: Trajectory) -> Trajectory:
    """The torques as they are, and another search next time."""
    status = TrajectoryStatus.OPEN_ENDED
    return replace(trajectory, status=status, solution=None, searches_left=1)
