"""Bearing friction, estimated per wheel from what the motor gave and what the rotor kept.

Over one control period a rotor's spin momentum changes by the motor's impulse less friction's,

    p_1 - p_0 = impulse - T f,      f = c_C tanh(Omega / s) + c_v Omega      (means over the period)

which is linear in the Coulomb and viscous coefficients: recursive least squares. Plans are made in
the torque that the rotor keeps; what friction will take is added to the command.
"""

from dataclasses import dataclass

import numpy as np

from ...ground.arrays import Array, WheelVector
from ...model.bearing import COULOMB_TANH_SPEED

BREAKAWAY_TORQUE = 2e-5  # Nm: a smaller wish does not set a resting wheel in motion
COULOMB_PRIOR = 2e-3  # Nm, 1 sigma: a small wheel's bearing
VISCOUS_PRIOR = 5e-6  # Nms/rad, 1 sigma
TORQUE_NOISE = 2e-5  # Nm, 1 sigma: of the mean torque over a period
RAMP_UNCERTAINTY = 0.1  # of a change of torque, added to the noise: samples may be late
NEAR_LIMIT = 0.99  # of the speed limit: beyond, the motor's torque is cut and passes for friction
ON_THE_WAY = 10.0  # times s: the least speed for which torque is kept back; tanh is 1 there


@dataclass(frozen=True)
class FrictionEstimate:
    """Mean and covariance of (c_C, c_v) for each wheel."""

    mean: Array
    """Shape (m, 2)."""
    covariance: Array
    """Shape (m, 2, 2)."""

    def torque(self, speed: WheelVector) -> WheelVector:
        """Friction torque to expect at wheel speeds (rad/s), Nm, along the speed."""
        return np.sum(_features(speed) * self.mean, axis=-1)

    def breakaway(self, speed: WheelVector, wanted: WheelVector) -> WheelVector:
        """Friction to overcome so that the rotor feels `wanted` (Nm): that of the speed (rad/s),
        and of a wheel at rest all of the Coulomb part, against the way it is to go."""
        leaning = np.tanh(speed / COULOMB_TANH_SPEED + wanted / BREAKAWAY_TORQUE)
        return self.mean[:, 0] * leaning + self.mean[:, 1] * speed

    def reserve(self, speed: WheelVector) -> WheelVector:
        """Motor torque to keep back for friction at these speeds and on the way to them, Nm."""
        return np.abs(self.torque(np.maximum(np.abs(speed), ON_THE_WAY * COULOMB_TANH_SPEED)))


def no_friction(wheels: int) -> FrictionEstimate:
    """The estimate before anything was measured."""
    prior = np.diag([COULOMB_PRIOR**2, VISCOUS_PRIOR**2])
    return FrictionEstimate(np.zeros((wheels, 2)), np.repeat(prior[None], wheels, axis=0))


def friction_update(
    friction: FrictionEstimate,
    lost: WheelVector,
    speeds: Array,
    ramp: WheelVector,
    speed_max: WheelVector,
) -> FrictionEstimate:
    """The estimate after one more period.

    `lost` is the mean torque between motor and rotor (Nm), `speeds` the wheel speeds sampled over
    the period (rad/s, shape (k, m)), `ramp` the size of the torque's change at its start (Nm),
    which a late sample would take for friction. Wheels that came near a standstill, where the sign
    of friction can't be relied upon, or near their speed limit teach nothing.
    """
    mean, covariance = friction.mean.copy(), friction.covariance.copy()
    features, size = _features(speeds).mean(axis=0), np.abs(speeds)
    turning = np.all((size > COULOMB_TANH_SPEED) & (size < NEAR_LIMIT * speed_max), axis=0)
    for j in np.flatnonzero(turning):
        h, noise = features[j], TORQUE_NOISE + RAMP_UNCERTAINTY * ramp[j]
        gain = covariance[j] @ h / (h @ covariance[j] @ h + noise**2)
        mean[j] += gain * (lost[j] - h @ mean[j])
        covariance[j] -= np.outer(gain, h @ covariance[j])
    return FrictionEstimate(mean, covariance)


def _features(speed: Array) -> Array:
    return np.stack([np.tanh(speed / COULOMB_TANH_SPEED), speed], axis=-1)
