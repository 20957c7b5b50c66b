"""First guesses of a plan that lead a local solver away from saddles.

At rest with an error purely about the unactuated axis n, or exactly half a turn away, the cost's
gradient by the torques vanishes and not moving looks optimal to any local method. Two shapes break
the symmetry: a *turn*, about the error's axis to rest at half the horizon's pace, and a *loop*, a
torque that goes round once in the actuated plane, whose area turns the body about n.
"""

from enum import Enum

import numpy as np

from ..ground.arrays import Array, Quaternion, WheelVector
from ..ground.attitude import rotation_vector
from ..ground.spacecraft import Spacecraft


class Guess(Enum):
    """Where the solver started from, as a sentence."""

    PREVIOUS = "The previous plan, shifted by one period."
    COAST = "No torque at all."
    TURN = "A turn about the error's axis."
    LOOP_LEFT = "A left-handed loop about the unactuated axis."
    LOOP_RIGHT = "A right-handed loop about the unactuated axis."


def shifted(plan: Array) -> Array:
    """The plan one period later, its last input repeated, shape (N, m)."""
    return np.concatenate([plan[1:], plan[-1:]])


def shapes(
    spacecraft: Spacecraft, torque_scale: WheelVector, q_BT: Quaternion, N: int, period: float
) -> dict[Guess, Array]:
    """Plans (N, m) that leave a saddle, for an attitude error q_BT."""
    body_torques = {Guess.TURN: _turn(spacecraft, q_BT, N, period)}
    n = spacecraft.unactuated
    if n is not None:
        loop = _loop(spacecraft, n, abs(float(rotation_vector(q_BT) @ n)), N, period)
        body_torques |= {Guess.LOOP_LEFT: loop[0], Guess.LOOP_RIGHT: loop[1]}
    to_wheels = -np.linalg.pinv(spacecraft.A).T
    return {
        guess: np.clip(torque @ to_wheels, -torque_scale, torque_scale)
        for guess, torque in body_torques.items()
    }


def _turn(spacecraft: Spacecraft, q_BT: Quaternion, N: int, period: float) -> Array:
    """Body torque that turns by the error and stops: a = 4 J phi / T^2, then its opposite."""
    torque = -4.0 * spacecraft.J @ rotation_vector(q_BT) / (N * period) ** 2
    direction = np.where(np.arange(N) < N / 2, 1.0, -1.0)
    return direction[:, None] * torque


def _loop(
    spacecraft: Spacecraft, n: Array, angle: float, N: int, period: float
) -> tuple[Array, Array]:
    """Body torques a (e1 cos nu t -+ e2 sin nu t), one round per horizon, for an angle about n.

    The rates of a torque a have amplitude a / (J nu) and enclose the angle pi (a / (J nu^2))^2.
    """
    e1 = np.linalg.svd(spacecraft.A)[0][:, 0]
    e2 = np.cross(n, e1)
    nu = 2.0 * np.pi / (N * period)
    amplitude = np.trace(spacecraft.J) / 3.0 * nu**2 * np.sqrt(max(angle, 1e-3) / np.pi)
    phase = nu * period * (np.arange(N)[:, None] + 0.5)
    cosine, sine = amplitude * np.cos(phase) * e1, amplitude * np.sin(phase) * e2
    return cosine - sine, cosine + sine
