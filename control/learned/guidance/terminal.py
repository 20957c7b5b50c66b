"""Terminal control: the torques that end a plan of K periods at rest in the goal.

Newton's method on the few terminal conditions, each step the least change of the plan within the
torque limits (`least_change`), with a slight pull towards less effort. With K just above the
shortest time the plan is nearly time-optimal; re-solved every period with one period less it is
also the feedback. The last interval carries no torque: the motors' ramp down belongs to the plan.

A prediction model that knows the appendages also asks that they be at rest at the end, as far as
the terminal conditions leave room for it (input shaping, found by the same step).
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ...ground.arrays import Array, Quaternion, WheelVector
from ...model.momentum import MomentumModel, actuated_basis
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

    def torque_bound(self, periods: int) -> Array:
        """Limits of all torques, Nm, shape (K, m): none in the last period."""
        bound = np.tile(self.torque_max, (periods, 1))
        bound[-1] = 0.0
        return bound


@dataclass(frozen=True)
class TerminalSolution:
    """A plan and where it ends."""

    torque: Array
    """Torque the rotors keep, Nm, shape (K, m)."""
    x: Array
    """States (q, p, u_prev) at the K + 1 instants."""
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
    """By all torques, shape (conditions, K m)."""


def solve_terminal(problem: TerminalProblem, guess: Array, iterations: int = 6) -> TerminalSolution:
    """The best plan found from a guess of shape (K, m), in at most so many Newton steps."""
    bound = problem.torque_bound(len(guess))
    rows = condition_rows(problem.model, problem.conditions)
    u, change = np.clip(guess, -bound, bound), np.inf
    best: TerminalSolution | None = None
    for iteration in range(iterations + 1):
        at = _linearised(problem, rows, u)
        if best is None or at.terminal_error < best.terminal_error:
            best = TerminalSolution(u, at.x, at.terminal_error, iteration)
        converged = at.terminal_error < CONVERGED and change < SETTLED
        if iteration == iterations or converged or np.isinf(at.terminal_error):
            break
        step = _newton_step(at, u, bound)
        change, u = float(np.max(np.abs(step - u))), step
    assert best is not None
    return best


def _linearised(problem: TerminalProblem, rows: Array, u: Array) -> Linearisation:
    """End of the plan u (K, m) and its slope; an infinite error where the prediction ran wild."""
    lengths = np.full(len(u), problem.period)
    end, slope, x = problem.propagator.linearize(
        problem.model, problem.x0, u, lengths, problem.goal
    )
    if not np.all(np.abs(slope) < DIVERGED) or not np.all(np.isfinite(end)):
        return Linearisation(x, np.inf, end, slope)
    rigid = rows.shape[1]
    error = rows @ end[:rigid]
    return Linearisation(
        x,
        float(np.max(np.abs(error))),
        np.concatenate([error, SWING_WEIGHT * end[rigid:]]),
        np.vstack([rows @ slope[:rigid], SWING_WEIGHT * slope[rigid:]]),
    )


def _newton_step(at: Linearisation, torque: Array, bound: Array) -> Array:
    """The nearest torques, a little eased, that meet the linearised conditions, shape (K, m)."""
    u, upper = torque.ravel(), bound.ravel()
    wanted = at.slope @ u - at.error
    step = least_change(u / (1.0 + EASE), at.slope, wanted, -upper, upper, SLACK)
    return step.reshape(torque.shape)


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
