"""Planning for the instant at which a command acts: the state ahead, for every controller alike.

A command that is computed and passed on for a while finds the craft further on. What acts meanwhile
is known, so that the measurement is replaced by the state that will be then, and every layer plans
from there. Readings of the past stay with it as they are, and the measurement itself goes along for
what learns from it. (A Smith predictor with the craft's own equations; Astrom and Wittenmark,
Computer-Controlled Systems, section 4.7.)
"""

from dataclasses import dataclass, replace

import numpy as np

from ..ground.arrays import Vector3
from ..ground.attitude import rotation_matrix
from ..ground.spacecraft import Spacecraft
from ..model.ahead import Motion, motion_ahead
from .belief import Belief
from .layers import InTransit
from .measurement import Measurement


@dataclass(frozen=True)
class Foresight:
    """Predicts with what is believed of the craft, or with what its planner has learned."""

    nominal: Spacecraft

    def foreseen(
        self, measurement: Measurement, transit: InTransit, belief: Belief | None
    ) -> Measurement:
        """The measurement as it will be when a command that is computed now begins to act."""
        J, friction = self.nominal.J, np.zeros(self.nominal.wheels)
        if belief is not None:
            J, friction = belief.J, friction if belief.friction is None else belief.friction
        now = Motion(measurement.q, measurement.omega, measurement.wheel_speed, transit.acting)
        then = motion_ahead(self.nominal, J, now, transit.pending, friction)
        return replace(
            measurement,
            q=then.q,
            omega=then.omega,
            wheel_speed=then.wheel_speed,
            torque=then.torque,
            field_B=_turned_field(measurement, then),
            origin=replace(measurement, torque=transit.acted),
        )


def _turned_field(measurement: Measurement, then: Motion) -> Vector3 | None:
    """The magnetic field in the body axes of then."""
    if measurement.field_B is None:
        return None
    field_N = rotation_matrix(measurement.q) @ measurement.field_B
    return rotation_matrix(then.q).T @ field_N
