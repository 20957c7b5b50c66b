"""Terminal control: the torques that end a plan of K periods at rest in the goal.

Newton's method on the few terminal conditions, each step the least change of the plan within the
torque limits (`least_change`), with a slight pull towards less effort. With K just above the
shortest time the plan is nearly time-optimal; re-solved every period with one period less it is
also the feedback. The last periods carry no torque: the motors' ramp down belongs to the plan.
Long plans are solved for on longer intervals (`grid`); a step is the least change of impulse.

A prediction model that knows the appendages also asks that they be at rest at the end, as far as
the terminal conditions leave room for it (input shaping, found by the same step).
"""

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from ...ground.arrays import Array, Quaternion, Vector3, WheelVector
from ...ground.spacecraft import Spacecraft
from ...model.momentum import MomentumModel, actuated_basis
from ..prediction.grid import Lengths, gathered, interval_lengths, seconds, spread
from ..prediction.propagation import Propagator
from .least_change import least_change

# Taken over from the first slews; half and twice change little: docs/learned.md.
EASE = 0.05  # share of the torques given up per step for less effort
SLACK = 1e-6  # eps of `least_change`: misses a condition by 1e-6 rad per unit of multiplier
CONVERGED = 3e-5  # rad, rad/s: 0.002 deg, below any error flown; half or twice changes nothing
SETTLED = 1e-4  # Nm: largest change of a torque in the last step, 0.2 % of the paper's limit
DIVERGED = 1e6  # rad/Nm: a slope beyond, or that is no number, comes from a prediction run wild
SWING_WEIGHT = 0.03  # s: weight of the appendages' motion at the end, beside the conditions


class TerminalConditions(Enum):
    """What the end of a plan must meet; the value is a sentence."""

    FULL = "All of the attitude, at rest."
    ACTUATED = "The attitude that wheels can move directly, at rest."


@dataclass(frozen=True)
class TerminalProblem:
    """Where a plan starts, and how it must end."""

    propagator: Propagator
    model: MomentumModel
    x0: Array
    """As `propagator` wants it: (q, p, u_prev, ...)."""
    goal: Quaternion
    torque_max: WheelVector
    """Nm."""
    period: float
    """s."""
    conditions: TerminalConditions = TerminalConditions.FULL
    goal_rate: Vector3 | None = None
    """Rate at which the goal turns when the plan ends, rad/s, its own axes; None stands still."""

    @cached_property
    def turning(self) -> Array:
        """What the end has to carry besides, for the body to turn with the goal: with it
        B'(A p - R'h_N + J_hub w_goal) = 0, scaled as `end` is, shape (3 + rank)."""
        B = actuated_basis(self.model.spacecraft)
        momentum = np.zeros(B.shape[1])
        if self.goal_rate is not None:
            size = np.trace(self.model.spacecraft.J) / 3.0
            momentum = B.T @ (self.model.J_hub @ self.goal_rate) / size
        return np.concatenate([np.zeros(3), momentum])

    def torque_bound(self, intervals: int) -> Array:
        """Limits of all torques, Nm, shape (N, m): zero while the motors ramp down at the end."""
        bound = np.tile(self.torque_max, (intervals, 1))
        ramp = ramp_periods(self.model.spacecraft, self.torque_max, self.period)
        bound[-min(ramp, intervals) :] = 0.0
        return bound


@dataclass(frozen=True)
class TerminalSolution:
    """A plan and where it ends."""

    torque: Array
    """Torque the rotors keep in each period, Nm, shape (K, m)."""
    x: Array
    """States (q, p, u_prev) between the intervals, the first and the last included."""
    terminal_error: float
    """Largest condition left over, rad or rad/s; inf where the prediction gave no numbers."""
    iterations: int


@dataclass(frozen=True)
class Linearisation:
    """The end of a plan about some torques."""

    x: Array
    terminal_error: float
    error: Array
    """The terminal conditions, and with a small weight the appendages' motion."""
    slope: Array
    """By all torques, shape (conditions, N m)."""


def solve_terminal(problem: TerminalProblem, guess: Array, iterations: int = 6) -> TerminalSolution:
    """The best plan found from a guess of shape (K, m), in at most so many Newton steps."""
    lengths = interval_lengths(len(guess), problem.propagator.even)
    bound = problem.torque_bound(len(lengths))
    rows = condition_rows(problem.model, problem.conditions)
    u, change = np.clip(gathered(guess, lengths), -bound, bound), np.inf
    best: TerminalSolution | None = None
    for iteration in range(iterations + 1):
        at = _linearised(problem, rows, u, lengths)
        if best is None or at.terminal_error < best.terminal_error:
            best = TerminalSolution(spread(u, lengths), at.x, at.terminal_error, iteration)
        converged = at.terminal_error < CONVERGED and change < SETTLED
        if iteration == iterations or converged or np.isinf(at.terminal_error):
            break
        step = _newton_step(at, u, bound, lengths)
        change, u = float(np.max(np.abs(step - u))), step
    assert best is not None
    return best


def _linearised(problem: TerminalProblem, rows: Array, u: Array, lengths: Lengths) -> Linearisation:
    """End of the plan u (N, m) and its slope; an infinite error where the prediction ran wild."""
    end, slope, x = problem.propagator.linearize(
        problem.model, problem.x0, u, seconds(lengths, problem.period), problem.goal
    )
    if not np.all(np.abs(slope) < DIVERGED) or not np.all(np.isfinite(end)):
        return Linearisation(x, np.inf, end, slope)
    rigid = rows.shape[1]
    error = rows @ (end[:rigid] + problem.turning)
    return Linearisation(
        x,
        float(np.max(np.abs(error))),
        np.concatenate([error, SWING_WEIGHT * end[rigid:]]),
        np.vstack([rows @ slope[:rigid], SWING_WEIGHT * slope[rigid:]]),
    )


def _newton_step(at: Linearisation, torque: Array, bound: Array, lengths: Lengths) -> Array:
    """The nearest torques, a little eased, that meet the linearised conditions, shape (N, m)."""
    weight = np.sqrt(np.repeat(lengths, torque.shape[1]))
    u, upper, slope = weight * torque.ravel(), weight * bound.ravel(), at.slope / weight
    wanted = slope @ u - at.error
    step = least_change(u / (1.0 + EASE), slope, wanted, -upper, upper, SLACK)
    return (step / weight).reshape(torque.shape)


def ramp_periods(spacecraft: Spacecraft, torque_max: WheelVector, period: float) -> int:
    """Periods, at least one, in which every motor comes to rest from any torque."""
    ramp = float(np.max(torque_max / spacecraft.torque_rate_max))
    return max(1, int(np.ceil(ramp / period)))


def condition_rows(model: MomentumModel, conditions: TerminalConditions) -> Array:
    """Rows that turn the end of a propagation into the conditions, shape (conditions, 3 + rank).

    Underactuated, the attitude is taken apart into phi_n = n'J phi / n'J n, which only a loop of
    the wheels can change, and the part in the wheels' plane.
    """
    B, tilt = actuated_basis(model.spacecraft), model.tilt
    rank = B.shape[1]
    attitude = np.eye(3) if tilt is None else np.vstack([tilt, B.T])
    rows = np.zeros((len(attitude) + rank, 3 + rank))
    rows[: len(attitude), :3], rows[len(attitude) :, 3:] = attitude, np.eye(rank)
    return rows[1:] if conditions is TerminalConditions.ACTUATED and tilt is not None else rows
