"""Exact arrival: the torques that end a plan of K periods at rest in the goal.

Newton's method on the few equations of arrival, each step the least change of the plan within the
torque limits (`least_change`), with a slight pull towards less effort. With K just above the
shortest time the plan is nearly time-optimal; re-solved every period with one period less it is
also the feedback. The last interval carries no torque: the motors' ramp down belongs to the plan.

A prediction that knows what is loose also asks that it be at rest at the end, as far as the
equations of arrival leave room for it (input shaping, found by the same step).
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ...ground.arrays import Array, Quaternion, WheelVector
from ...model.momentum import MomentumModel, actuated_basis
from .arc import Arcs, fly_arc
from .least_change import least_change

EASE = 0.05  # share of the torques given up per step for less effort
SLACK = 1e-6  # eps of `least_change`: misses an equation by 1e-6 rad per unit of multiplier
CONVERGED = 3e-5  # rad, rad/s: 0.002 deg
SETTLED = 1e-4  # Nm: largest change of a torque in the last step
ABSURD = 1e6  # rad/Nm: a slope beyond, or that is no number, comes from a prediction run wild
CALM = 0.03  # s: weight of what still swings at the end, beside the equations of arrival


class Equations(Enum):
    """What the end of a plan must meet; the value is a sentence."""

    ALL = "All of the attitude, at rest."
    ACTUATED = "The attitude that wheels can move directly, at rest."


@dataclass(frozen=True)
class Steering:
    """A plan and where it ends."""

    torque: Array
    """Torque the rotors keep, Nm, shape (K, m)."""
    x: Array
    """States (q, p, u_prev) at the K + 1 instants."""
    miss: float
    """Largest equation left over, rad or rad/s; inf where the prediction gave no numbers."""
    iterations: int


def steer(
    arcs: Arcs,
    model: MomentumModel,
    x0: Array,
    goal: Quaternion,
    guess: Array,
    torque_max: WheelVector,
    period: float,
    equations: Equations = Equations.ALL,
    iterations: int = 6,
) -> Steering:
    """The best plan found from a guess of shape (K, m), in at most so many Newton steps."""
    K, m = guess.shape
    upper = np.tile(torque_max, K)
    upper[-m:] = 0.0
    select = selection(model, equations)
    rigid = select.shape[1]
    u = np.clip(guess.ravel(), -upper, upper)
    best: Steering | None = None
    change = np.inf
    for iteration in range(iterations + 1):
        end, slope, x = fly_arc(arcs, model, x0, u.reshape(K, m), period, goal)
        if not np.all(np.abs(slope) < ABSURD) or not np.all(np.isfinite(end)):
            best = best or Steering(u.reshape(K, m), x, np.inf, iteration)
            break
        swing, swing_slope = CALM * end[rigid:], CALM * slope[rigid:]
        end, slope = select @ end[:rigid], select @ slope[:rigid]
        miss = float(np.max(np.abs(end)))
        if best is None or miss < best.miss:
            best = Steering(u.reshape(K, m), x, miss, iteration)
        if iteration == iterations or (miss < CONVERGED and change < SETTLED):
            break
        end, slope = np.concatenate([end, swing]), np.vstack([slope, swing_slope])
        step = least_change(u / (1.0 + EASE), slope, slope @ u - end, -upper, upper, SLACK)
        change, u = float(np.max(np.abs(step - u))), step
    assert best is not None
    return best


def selection(model: MomentumModel, equations: Equations) -> Array:
    """Rows that turn the arc's end into the equations, shape (equations, 3 + rank).

    Underactuated, the attitude is taken apart into phi_n = n'J phi / n'J n, which only a loop of
    the wheels can change, and the part in the wheels' plane.
    """
    B, tilt = actuated_basis(model.spacecraft), model.tilt
    rank = B.shape[1]
    attitude = np.eye(3) if tilt is None else np.vstack([tilt, B.T])
    rows = np.zeros((len(attitude) + rank, 3 + rank))
    rows[: len(attitude), :3], rows[len(attitude) :, 3:] = attitude, np.eye(rank)
    return rows[1:] if equations is Equations.ACTUATED and tilt is not None else rows
