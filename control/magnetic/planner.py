"""A planner of wheel torques with that of the rods' dipoles beside it.

The dipoles are planned from the same measurement, with what the torque planner has learned. While
the field is not known (a magnetometer is blind beside rods that are on) it is taken as it was last
known in inertial axes: an orbit turns it by a degree in eight seconds. Without a measurement the
rods are off.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..ground.arrays import Vector3, WheelVector
from ..ground.attitude import rotation_matrix
from ..interface.belief import Belief
from ..interface.blind import plan_blind
from ..interface.layers import Memory, Planner
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from .dipoles import DipoleLaw, DipoleState


@dataclass(frozen=True)
class RodMemory:
    """What one plan hands to the next."""

    planner: Memory = None
    """The torque planner's own."""
    dipoles: DipoleState = field(default_factory=DipoleState)
    field_N: Vector3 | None = None
    """The field as it was last known, T, inertial axes."""


@dataclass(frozen=True, eq=False)
class RodPlanner:
    """A planner whose plans have dipoles."""

    inner: Planner
    """Plans the torques."""
    law: DipoleLaw

    def plan(self, measurement: Measurement, memory: RodMemory | None) -> tuple[Plan, RodMemory]:
        """The inner plan, with dipoles for the coming period."""
        memory = memory or RodMemory()
        plan, planner = self.inner.plan(measurement, memory.planner)
        field_N = memory.field_N
        R = rotation_matrix(measurement.q)
        if measurement.field_B is not None:
            field_N = R @ measurement.field_B
        if field_N is None:
            return plan, RodMemory(planner)
        belief = plan.belief or Belief(self.law.spacecraft.J)
        dipole, dipoles = self.law.dipoles(measurement, R.T @ field_N, belief, memory.dipoles)
        return replace(plan, dipole=dipole), RodMemory(planner, dipoles, field_N)

    def fly_on(self, torque: WheelVector, memory: RodMemory | None) -> tuple[Plan, RodMemory]:
        """The inner planner's answer to a period without a measurement, rods off."""
        memory = memory or RodMemory()
        plan, planner = plan_blind(self.inner, torque, memory.planner)
        off = np.zeros(self.law.spacecraft.rods.count)
        return replace(plan, dipole=off), RodMemory(planner, field_N=memory.field_N)
