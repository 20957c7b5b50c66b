"""Bearing friction, estimated per wheel from what the motor gave and what the rotor kept.

Over one control period a rotor's spin momentum changes by the motor's impulse less friction's,

    p_1 - p_0 = impulse - T f,      f = c_C tanh(Omega / s) + c_v Omega      (means over the period)

which is linear in the Coulomb and viscous coefficients: recursive least squares. Plans are made in
the torque that the rotor keeps; what friction will take is added to the command.

One speed tells the sum of the two and not its parts. So their priors are as wide as friction can
be, and near standstill, where the Coulomb part would push alone, it counts as far as it is known
apart. An estimate that a new period contradicts is forgotten: the next ones decide anew.
"""

from dataclasses import dataclass

import numpy as np

from ...ground.arrays import Array, WheelVector
from ...ground.spacecraft import Spacecraft
from ...model.bearing import COULOMB_TANH_SPEED

BREAKAWAY_TORQUE = 2e-5  # Nm: a smaller wish sets no resting wheel in motion (as TORQUE_NOISE)
COULOMB_PRIOR = 2e-3  # Nm, 1 sigma: twice the bearing of models/two_wheel_friction
TINY = np.finfo(float).tiny  # Nm^2: stands for no friction in a denominator
VISCOUS_SHARE = 0.5  # of the torque limit at the speed limit, 1 sigma: at 1 no wheel would reach it
VISCOUS_PRIOR = 4e-5  # Nms/rad, 1 sigma, where there are no limits: the same for the paper's wheels
IMPULSE_NOISE = 1e-5  # Nms, 1 sigma, over a period: 1.3e-5 Nm for 0.5 s are left over in flight
RAMP_UNCERTAINTY = 0.1  # of a change of torque, added to the noise: samples may be late
SAMPLES_FOR_SCATTER = 11  # seven fourth differences: the end of a ramp is in three of them
NEAR_LIMIT = 0.99  # of the speed limit: beyond, the motor's torque is cut and passes for friction
ON_THE_WAY = 10.0  # times s: the least speed for which torque is kept back; tanh is 1 there
CONTRADICTED = 4.0  # innovation in standard deviations; in flights of the zoo it stays below 0.5


@dataclass(frozen=True)
class FrictionEstimate:
    """Mean and covariance of (c_C, c_v) for each wheel."""

    mean: Array
    """Shape (m, 2)."""
    covariance: Array
    """Shape (m, 2, 2)."""

    def torque(self, speed: WheelVector) -> WheelVector:
        """Friction torque to expect at wheel speeds (rad/s), Nm, along the speed."""
        return self._coulomb(speed) * np.tanh(speed / COULOMB_TANH_SPEED) + self.mean[:, 1] * speed

    def breakaway(self, speed: WheelVector, wanted: WheelVector) -> WheelVector:
        """Friction to overcome so that the rotor feels `wanted` (Nm): that of the speed (rad/s),
        and of a wheel at rest all of the Coulomb part, against the way it is to go."""
        leaning = np.tanh(speed / COULOMB_TANH_SPEED + wanted / BREAKAWAY_TORQUE)
        return self._coulomb(speed) * leaning + self.mean[:, 1] * speed

    def reserve(self, speed: WheelVector) -> WheelVector:
        """Motor torque to keep back for friction at these speeds and on the way to them, Nm."""
        return np.abs(self.torque(np.maximum(np.abs(speed), ON_THE_WAY * COULOMB_TANH_SPEED)))

    def _coulomb(self, speed: WheelVector) -> WheelVector:
        """Coulomb friction to count on at wheel speeds, Nm: all of it where wheels turn, where its
        sum with the viscous part is what was measured; at rest as far as it is known apart."""
        c, variance = np.maximum(self.mean[:, 0], 0.0), self.covariance[:, 0, 0]
        known = c**2 / np.maximum(c**2 + variance, TINY)
        turning = np.minimum(np.abs(speed) / (ON_THE_WAY * COULOMB_TANH_SPEED), 1.0)
        return c * (known + (1.0 - known) * turning)


def no_friction(spacecraft: Spacecraft) -> FrictionEstimate:
    """The estimate before anything was measured."""
    m = spacecraft.wheels
    prior = np.tile(np.diag([COULOMB_PRIOR**2, 0.0]), (m, 1, 1))
    with np.errstate(invalid="ignore"):
        share = VISCOUS_SHARE * spacecraft.torque_max / spacecraft.speed_max
    limited = np.isfinite(spacecraft.torque_max) & np.isfinite(spacecraft.speed_max)
    prior[:, 1, 1] = np.where(limited, share, VISCOUS_PRIOR) ** 2
    return FrictionEstimate(np.zeros((m, 2)), prior)


def friction_update(
    friction: FrictionEstimate,
    lost: WheelVector,
    speeds: Array,
    ramp: WheelVector,
    scatter: WheelVector,
    period: float,
    spacecraft: Spacecraft,
) -> FrictionEstimate:
    """The estimate after one more period (s).

    `lost` is the mean torque between motor and rotor (Nm), `speeds` the wheel speeds sampled over
    the period (rad/s, shape (k, m)), `ramp` the size of the torque's change at its start (Nm),
    which a late sample would take for friction, `scatter` the noise of a sample of the spin
    momentum (Nms, 1 sigma). Wheels that came near a standstill, where the sign of friction can't be
    relied upon, or near their speed limit teach nothing.
    """
    mean, covariance = friction.mean.copy(), friction.covariance.copy()
    features: Array = np.asarray(np.trapezoid(_features(speeds), axis=0)) / (len(speeds) - 1)
    size = np.abs(speeds)
    fast = size < NEAR_LIMIT * spacecraft.speed_max
    turning = np.all((size > COULOMB_TANH_SPEED) & fast, axis=0)
    for j in np.flatnonzero(turning):
        h, impulse = features[j], max(IMPULSE_NOISE, np.sqrt(2.0) * scatter[j])
        noise = impulse / period + RAMP_UNCERTAINTY * ramp[j]
        innovation = lost[j] - h @ mean[j]
        if innovation**2 > CONTRADICTED**2 * (h @ covariance[j] @ h + noise**2):
            covariance[j] = no_friction(spacecraft).covariance[j]
        gain = covariance[j] @ h / (h @ covariance[j] @ h + noise**2)
        mean[j] += gain * innovation
        covariance[j] -= np.outer(gain, h @ covariance[j])
    return FrictionEstimate(mean, covariance)


def momentum_scatter(momentum: Array) -> WheelVector:
    """Noise of a sample (1 sigma) by the median fourth difference, which is blind to a constant
    torque and to the end of a ramp; of samples (k, m), zero if they are too few to tell."""
    if len(momentum) < SAMPLES_FOR_SCATTER:
        return np.zeros(momentum.shape[1])
    rough = np.median(np.abs(np.diff(momentum, n=4, axis=0)), axis=0)
    return np.asarray(rough / (0.6745 * np.sqrt(70.0)))  # of a normal distribution, 5 samples each


def _features(speed: Array) -> Array:
    return np.stack([np.tanh(speed / COULOMB_TANH_SPEED), speed], axis=-1)
