"""Where a spacecraft with wheels will be when torques that are already commanded have acted.

In momentum form (see `momentum`) the wheels' part is exact, ramps included, and the total momentum
is that of the state itself, so that no force is needed but the motors':

    p_1 = p + impulse      h_N = R(q) (J omega + A (Js * Omega))
    q' = 1/2 q (x) (0, omega)      omega = J_hub^-1 (R(q)' h_N - A p)

by Runge-Kutta steps of fourth order, short enough for the fastest slew. Torques from outside are
left out: over half a second they give 1e-6 Nms.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Matrix3, Quaternion, Vector3, WheelVector
from ..ground.attitude import multiply, normalized, rotation_matrix
from ..ground.spacecraft import Spacecraft
from .momentum import MomentumModel, spin_momentum

STEP = 0.05  # s: 16 deg/s turn by 0.014 rad, whose fourth power is 4e-8

Pending = Iterable[tuple[float, WheelVector]]
"""Commands that are yet to act, in order: (seconds, Nm)."""


@dataclass(frozen=True)
class Motion:
    """Attitude, rates and torque at one instant."""

    q: Quaternion
    omega: Vector3
    """Body axes, rad/s."""
    wheel_speed: WheelVector
    """Relative to the hub, rad/s."""
    torque: WheelVector
    """Acting on the rotors, Nm."""


def motion_ahead(
    craft: Spacecraft, J: Matrix3, now: Motion, pending: Pending, friction: WheelVector
) -> Motion:
    """The motion after all pending commands (Nm) have acted for their time.

    `J` is believed of the inertia, `friction` (Nm, along the wheel speeds) of the bearings' torque.
    """
    h_N = rotation_matrix(now.q) @ (J @ now.omega + craft.A @ (craft.Js * now.wheel_speed))
    model = MomentumModel(craft, J, h_N)
    q, p, u = now.q, spin_momentum(craft, now.omega, now.wheel_speed), now.torque
    for seconds, command in pending:
        target = np.clip(command, -craft.torque_max, craft.torque_max)
        steps = max(1, round(seconds / STEP))
        for _ in range(steps):
            h = seconds / steps
            half, _ = _motor(u, target, craft.torque_rate_max, 0.5 * h)
            full, u = _motor(u, target, craft.torque_rate_max, h)
            q, p = _turned(model, q, p, (half - 0.5 * h * friction, full - h * friction), h)
    omega = model.rate(q, p)
    return Motion(q, omega, p / craft.Js - omega @ craft.A, u)


def _motor(
    torque: WheelVector, target: WheelVector, rate: WheelVector, h: float
) -> tuple[WheelVector, WheelVector]:
    """Impulse over h (Nms) and torque after it (Nm) of motors that ramp to their target."""
    change = target - torque
    ramp = np.minimum(np.abs(change) / rate, h)  # s, 0 without a rate limit
    at_end = torque + np.clip(change, -h * rate, h * rate)
    return ramp * 0.5 * (torque + at_end) + (h - ramp) * at_end, at_end


def _turned(
    model: MomentumModel,
    q: Quaternion,
    p: WheelVector,
    impulses: tuple[WheelVector, WheelVector],
    h: float,
) -> tuple[Quaternion, WheelVector]:
    """Attitude and spin momenta after h, from the impulses at half time and at the end."""
    at_half, at_end = p + impulses[0], p + impulses[1]
    first = _rotation_rate(model, q, p)
    second = _rotation_rate(model, q + 0.5 * h * first, at_half)
    third = _rotation_rate(model, q + 0.5 * h * second, at_half)
    fourth = _rotation_rate(model, q + h * third, at_end)
    return normalized(q + h / 6.0 * (first + 2.0 * (second + third) + fourth)), at_end


def _rotation_rate(model: MomentumModel, q: Quaternion, p: WheelVector) -> Quaternion:
    return 0.5 * multiply(q, np.array([0.0, *model.rate(normalized(q), p)]))
