"""What the controller is told at a control instant: numbers from the sensors, never the plant."""

from dataclasses import dataclass, field

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


@dataclass(frozen=True)
class History:
    """Samples since the previous control instant, oldest first, the current one last (20 Hz)."""

    t: Array
    """Sample times, s, shape (k,)."""
    omega: Vectors3
    """Body rates in body axes, rad/s, shape (k, 3)."""
    wheel_speed: WheelVectors
    """Wheel speeds relative to the hub, rad/s, shape (k, m)."""


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
