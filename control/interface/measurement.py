"""What the controller is told at a control instant: numbers from the sensors, never the plant."""

from dataclasses import dataclass, field, replace

import numpy as np

from ..ground.arrays import (
    Array,
    Quaternion,
    RodVector,
    Vector3,
    Vectors3,
    WheelVector,
    WheelVectors,
)
from ..ground.units import Units


@dataclass(frozen=True)
class History:
    """Samples since the previous control instant, oldest first, the current one last (20 Hz)."""

    t: Array
    """Sample times, s, shape (k,)."""
    omega: Vectors3
    """Body rates in body axes, rad/s, shape (k, 3)."""
    wheel_speed: WheelVectors
    """Wheel speeds relative to the hub, rad/s, shape (k, m)."""

    def in_units(self, units: Units) -> "History":
        """The same in other units."""
        return History(self.t / units.time, self.omega / units.rate, self.wheel_speed / units.rate)


@dataclass(frozen=True)
class Measurement:
    """The state as sensed at time t."""

    t: float
    q: Quaternion
    """Attitude, body -> inertial."""
    omega: Vector3
    """Rate of the body relative to the inertial frame, body axes, rad/s."""
    wheel_speed: WheelVector
    """Speed of each rotor relative to the hub, rad/s."""
    torque: WheelVector
    """Motor torque commanded over the period that ends now, Nm (zero at the start)."""
    history: History
    """The last sample of the previous period and all samples since."""
    dipole: RodVector = field(default_factory=lambda: np.zeros(0))
    """Dipole of each magnetic rod commanded over the period that ends now, A m^2 (zero at the
    start; empty without rods)."""
    field_B: Vector3 | None = None
    """The Earth's magnetic field as known on board, body axes, T; None if it isn't known."""

    def in_units(self, units: Units) -> "Measurement":
        """The same in other units; the field goes with the torque and dipoles stay in A m^2, so
        that their product is a torque."""
        return replace(
            self,
            t=self.t / units.time,
            omega=self.omega / units.rate,
            wheel_speed=self.wheel_speed / units.rate,
            torque=self.torque / units.torque,
            field_B=None if self.field_B is None else self.field_B / units.torque,
            history=self.history.in_units(units),
        )
