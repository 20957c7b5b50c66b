"""What an agent sees and what its actions mean, for the environment and for a flight alike.

Observation, 7 + 2 m numbers for m wheels, float32:

    q_BT (4)              attitude of the body relative to the target, scalar first and not negative
    omega / w (3)         body rate, body axes; w is 0.1 rad in the craft's own second
    Omega / Omega_max (m) wheel speeds relative to the hub
    u / u_max (m)         motor torque over the period that ends now

Action: motor torque on each rotor over the coming period as a share of u_max, (m).
"""

from dataclasses import dataclass

import numpy as np

from simsat.control.ground.arrays import Array, Quaternion, WheelVector
from simsat.control.ground.attitude import error_quaternion
from simsat.control.interface.measurement import Measurement
from simsat.control.nmpc.planner import torque_scale
from simsat.flight.controllers import Brief

RATE_SCALE = 0.1  # rad in the craft's own second: a slew of the benchmark peaks at 0.2
RATE_BOUND = 10.0  # of the scale, 57 deg/s: beyond what any wheel here can store
SPEED_STAND_IN = 6000.0 * np.pi / 30.0  # rad/s, for a wheel without a limit: the benchmark's


@dataclass(frozen=True)
class Senses:
    """The numbers that scale what an agent sees and does."""

    target: Quaternion
    torque_scale: WheelVector
    """u_max, Nm; where the model has no limit, what a slew needs (`torque_scale` of the NMPC)."""
    speed_scale: WheelVector
    """Omega_max, rad/s."""
    rate_scale: float
    """w, rad/s."""

    def observe(self, now: Measurement) -> Array:
        """The observation of a measurement, inside `bounds`."""
        parts = [
            error_quaternion(now.q, self.target),
            now.omega / self.rate_scale,
            now.wheel_speed / self.speed_scale,
            now.torque / self.torque_scale,
        ]
        return np.clip(np.concatenate(parts), *self.bounds).astype(np.float32)

    def torque(self, action: Array) -> WheelVector:
        """Nm of an action, cut to [-1, 1]; float64 is taken as it is."""
        return np.clip(np.asarray(action, float), -1.0, 1.0) * self.torque_scale

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest observation."""
        m = len(self.torque_scale)
        high = np.concatenate([np.ones(4), np.full(3, RATE_BOUND), np.ones(2 * m)])
        low = -high
        low[0] = 0.0
        return low, high


def senses_of(brief: Brief) -> Senses:
    """The senses of an agent on a spacecraft."""
    craft, unit = brief.nominal, brief.units.rate
    finite = np.isfinite(craft.speed_max)
    speed = np.where(finite, craft.speed_max, SPEED_STAND_IN * unit)
    scale = torque_scale(craft, brief.settings.nmpc)
    return Senses(np.asarray(brief.target, float), scale, speed, RATE_SCALE * unit)
