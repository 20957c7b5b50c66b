"""A reference as a planner sees it that works in the craft's own units."""

from dataclasses import dataclass

from ..ground.arrays import Quaternions, Vectors3
from ..ground.units import Units
from .reference import Reference, Times


@dataclass(frozen=True)
class ReferenceInUnits:
    """The same reference, times and rates in other units."""

    reference: Reference
    units: Units

    @property
    def moving(self) -> bool:
        """Whether it ever changes."""
        return self.reference.moving

    def attitude(self, t: Times) -> Quaternions:
        """q_NT at time t."""
        return self.reference.attitude(t * self.units.time)

    def rate(self, t: Times) -> Vectors3:
        """w_TN_T at time t, T axes."""
        return self.reference.rate(t * self.units.time) / self.units.rate
