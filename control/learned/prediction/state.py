"""Where a plan starts: the spacecraft now, as one prediction model sees it."""

from dataclasses import dataclass

from ...ground.arrays import Array, Quaternion, WheelVector
from ...model.momentum import MomentumModel
from ..estimation.estimate import ModelEstimate
from .propagation import Propagator


@dataclass(frozen=True)
class PlanningState:
    """The present state, and all that is needed to predict from it."""

    propagator: Propagator
    """Where plans lead, by this prediction model."""
    model: MomentumModel
    estimate: ModelEstimate
    x0: Array
    """(q, p, torque the rotors keep now), and what `propagator` wants beside."""
    torque_max: WheelVector
    """What the rotors can be given, Nm: the limit less friction."""

    @property
    def q(self) -> Quaternion:
        """Attitude, body -> inertial."""
        return self.x0[:4]

    @property
    def p(self) -> WheelVector:
        """Spin momenta, Nms."""
        return self.x0[4 : 4 + self.model.spacecraft.wheels]
