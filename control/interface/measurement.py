"""What the controller is told at a control instant: numbers from the sensors, never the plant."""

from dataclasses import dataclass, field, replace

import numpy as np

from ..ground.arrays import (
    Array,
    Matrix3,
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
class Fix:
    """An attitude that an instrument took at t and delivers later, with what is known of its error,
    a small turn in body axes."""

    t: float
    q: Quaternion
    covariance: Matrix3
    """rad^2, body axes."""


@dataclass(frozen=True)
class Sighting:
    """A direction that is known in inertial axes, seen in body axes at t: the Sun, a field line."""

    t: float
    direction_B: Vector3
    """As measured, a unit vector."""
    direction_N: Vector3
    """As an almanac or a field model has it, a unit vector."""
    deviation: float
    """Of the angle between the two, about each axis across, rad, 1 sigma."""


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
    fixes: tuple[Fix, ...] = ()
    """What attitude instruments with a latency delivered since the previous instant."""
    sightings: tuple[Sighting, ...] = ()
    """Known directions seen since."""
    origin: "Measurement | None" = None
    """What the state was predicted from, where the command acts later than t (see `foresight`);
    what identifies a craft from the past takes `sensed`."""

    @property
    def sensed(self) -> "Measurement":
        """The measurement as it was sensed, if this one is a prediction."""
        return self if self.origin is None else self.origin

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
            fixes=tuple(replace(fix, t=fix.t / units.time) for fix in self.fixes),
            sightings=tuple(replace(s, t=s.t / units.time) for s in self.sightings),
            origin=None if self.origin is None else self.origin.in_units(units),
        )
