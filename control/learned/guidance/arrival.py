"""The arrival: the rest of the plan meets its end in everything that the wheels move directly.

An arrival that began early takes phi_n along whenever the time left allows it, but takes no longer
for it. One that misses by more than is worth waiting out is flown again, once (`missed`).
"""

from dataclasses import replace

import numpy as np

from ...ground.arrays import Quaternion
from ..prediction.state import PlanningState
from .drift import arrival_attitude, unactuated_error
from .hold import hold
from .task import ACCEPTED, PATIENCE, GuidanceTask, lengthened, too_fast
from .terminal import TerminalConditions, TerminalSolution
from .trajectory import Phase, Trajectory, TrajectoryStatus

WORTH_A_LOOP = np.deg2rad(0.1)  # phi_n below is left over: the loop costs as much as 97 s with it
MISSED = np.deg2rad(0.2)  # phi_n so far off on arrival: in 80 s it is more error than the loop
ARRIVAL_TIME = 1.5  # s: so close to the end no loop is left that would turn the body about n
OVERRUN = 2.0  # s by which an arrival may be put off; then the hold takes what is left


def arrive(task: GuidanceTask, trajectory: Trajectory, state: PlanningState) -> Trajectory:
    """The rest of the plan to its end, phi_n left as it comes; a period more where that misses."""
    solution = _solved(task, trajectory, state, 0)
    if solution.terminal_error > ACCEPTED and trajectory.overruns >= task.periods(OVERRUN):
        return hold(task, trajectory, state)
    if solution.terminal_error > ACCEPTED:
        trajectory = replace(trajectory, overruns=trajectory.overruns + 1)
        solution = _solved(task, trajectory, state, 1)
    return replace(
        trajectory,
        phase=Phase.ARRIVAL,
        torque=solution.torque,
        solution=solution,
        status=TrajectoryStatus.ARRIVAL,
    )


def arrive_early(
    task: GuidanceTask, trajectory: Trajectory, state: PlanningState, goal: Quaternion
) -> Trajectory | None:
    """An arrival that leaves phi_n as it is, where that is not worth a loop of its own."""
    arrival = arrive(task, trajectory, state)
    solution = arrival.solution
    assert solution is not None
    left = unactuated_error(state.model, solution.x[-1, :4], goal)
    return arrival if solution.terminal_error < ACCEPTED and abs(left) < WORTH_A_LOOP else None


def arrive_fully(
    task: GuidanceTask, trajectory: Trajectory, state: PlanningState
) -> Trajectory | None:
    """An arrival that began early and can meet all of the attitude after all. Without this phi_n
    would be left to what each period's plan, as it is solved anew, makes of it."""
    if trajectory.phase is not Phase.ARRIVAL or len(trajectory.torque) <= task.periods(
        ARRIVAL_TIME
    ):
        return None
    bias = task.bias(trajectory, state)
    goal = arrival_attitude(state.model, task.target, bias)
    solution = task.solve(state, goal, trajectory.torque, TerminalConditions.FULL, PATIENCE // 2)
    if solution.terminal_error > ACCEPTED or too_fast(state, solution):
        return None
    return replace(trajectory, torque=solution.torque, solution=solution, bias=bias)


def missed(task: GuidanceTask, trajectory: Trajectory, state: PlanningState) -> bool:
    """Whether a first arrival that ends now has left phi_n too far from where it aimed."""
    if trajectory.phase is not Phase.ARRIVAL or len(trajectory.torque) > 1 or trajectory.repeated:
        return False
    error = unactuated_error(state.model, state.q, task.target)
    return bool(abs(error - trajectory.bias) > MISSED)


def _solved(
    task: GuidanceTask, trajectory: Trajectory, state: PlanningState, extra: int
) -> TerminalSolution:
    goal = arrival_attitude(state.model, task.target, trajectory.bias)
    guess = lengthened(trajectory.torque, extra)
    return task.solve(state, goal, guess, TerminalConditions.ACTUATED, PATIENCE // 2)
