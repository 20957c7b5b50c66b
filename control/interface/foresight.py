"""Planning for the instant at which a command acts: the state ahead, for every controller alike.

A command that is computed and passed on for a while finds the craft further on. What acts meanwhile
is known, so that the measurement is replaced by the state that will be then, and every layer plans
from there. Readings of the past stay with it as they are, and the measurement itself goes along for
what learns from it. (A Smith predictor with the craft's own equations; Astrom and Wittenmark,
Computer-Controlled Systems, section 4.7.)
"""

from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np

from ..ground.arrays import Matrix3, WheelVector
from ..ground.spacecraft import Spacecraft
from ..model.ahead import Motion, motion_ahead
from .layers import InTransit, Memory, Planner
from .measurement import Measurement


@runtime_checkable
class KnowsCraft(Protocol):
    """A planner that has learned more of the craft than was believed before the flight."""

    def craft_now(
        self, memory: Memory, wheel_speed: WheelVector
    ) -> tuple[Matrix3, WheelVector] | None:
        """Inertia (kg m^2) and bearing friction at these speeds (Nm), None if nothing is known."""
        ...


@dataclass(frozen=True)
class Foresight:
    """Predicts with what is believed of the craft, or with what its planner has learned."""

    nominal: Spacecraft

    def foreseen(
        self, measurement: Measurement, transit: InTransit, planner: Planner, memory: Memory
    ) -> Measurement:
        """The measurement as it will be when a command that is computed now begins to act."""
        J, friction = self._craft(planner, memory, measurement.wheel_speed)
        now = Motion(measurement.q, measurement.omega, measurement.wheel_speed, transit.acting)
        then = motion_ahead(self.nominal, J, now, transit.pending, friction)
        return replace(
            measurement,
            q=then.q,
            omega=then.omega,
            wheel_speed=then.wheel_speed,
            torque=transit.last,
            origin=replace(measurement, torque=transit.acted),
        )

    def _craft(
        self, planner: Planner, memory: Memory, wheel_speed: WheelVector
    ) -> tuple[Matrix3, WheelVector]:
        if isinstance(planner, KnowsCraft) and memory is not None:
            known = planner.craft_now(memory, wheel_speed)
            if known is not None:
                return known
        return self.nominal.J, np.zeros(self.nominal.wheels)
