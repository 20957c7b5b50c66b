"""What a planner has learned of the spacecraft in flight, for the layers beside it."""

from dataclasses import dataclass, field

import numpy as np

from ..ground.arrays import Matrix3, Vector3, WheelVector
from ..ground.units import Units


@dataclass(frozen=True)
class Belief:
    """A spacecraft as it is believed to be now."""

    J: Matrix3
    """Inertia, kg m^2, body axes."""
    external_N: Vector3 = field(default_factory=lambda: np.array([0.0, 0.0, 0.0]))
    """External torque expected, that of magnetic rods left out, Nm, inertial axes."""
    friction: WheelVector | None = None
    """Torque of the bearings at the present wheel speeds, Nm; None if nothing is known of it."""

    def in_units(self, units: Units) -> "Belief":
        """The same in other units."""
        friction = None if self.friction is None else self.friction / units.torque
        return Belief(self.J / units.inertia, self.external_N / units.torque, friction)
