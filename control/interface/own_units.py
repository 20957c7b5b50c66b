"""The door of a planner that works in the craft's own units: SI outside, own units inside."""

from dataclasses import dataclass

from ..ground.arrays import WheelVector
from ..ground.units import Units
from .blind import plan_blind
from .layers import Memory, Planner
from .measurement import Measurement
from .plan import Plan


@dataclass(frozen=True)
class InOwnUnits:
    """A planner built from numbers in own units, as one that is told and answers SI.

    Its memory stays in own units: nobody else reads it.
    """

    planner: Planner
    units: Units

    def plan(self, measurement: Measurement, memory: Memory) -> tuple[Plan, Memory]:
        """The planner's answer to the measurement."""
        plan, memory = self.planner.plan(measurement.in_units(self.units), memory)
        return plan.in_units(self.units.back), memory

    def fly_on(self, torque: WheelVector, memory: Memory) -> tuple[Plan, Memory]:
        """Its answer to a period without one (see `blind`)."""
        plan, memory = plan_blind(self.planner, torque / self.units.torque, memory)
        return plan.in_units(self.units.back), memory
