"""Control periods without a measurement: what is commanded while the door refuses what is sensed.

A planner that has planned ahead flies its plan on; without one the wheels get no torque. Then the
momentum of body and wheels stays where it is and the body goes on turning as it did, while a torque
that is held would spin it up for as long as nothing is measured. No layer's memory learns anything
of such a period; corrector and supervisor are not asked.
"""

from enum import StrEnum
from typing import Protocol, runtime_checkable

import numpy as np

from ..ground.arrays import WheelVector
from .layers import Correction, Memory, Planner
from .plan import Plan
from .verdict import Decision, Reason, Verdict


class BlindStatus(StrEnum):
    """Where a command without a measurement comes from, as a sentence."""

    FLOWN_ON = "The measurement was refused; the previous plan is flown on."
    NO_TORQUE = "The measurement was refused and no plan is left; the wheels get no torque."


@runtime_checkable
class FliesOn(Protocol):
    """A planner that can do without a measurement for a while."""

    def fly_on(self, torque: WheelVector, memory: Memory) -> tuple[Plan, Memory]:
        """The torque for the coming period; `torque` (Nm) is what was commanded over the period
        that ends now."""
        ...


def plan_blind(planner: Planner, torque: WheelVector, memory: Memory) -> tuple[Plan, Memory]:
    """The planner's answer to a period without a measurement, or no torque if it has none."""
    if isinstance(planner, FliesOn):
        return planner.fly_on(torque, memory)
    return no_torque(len(torque)), memory


def no_torque(wheels: int) -> Plan:
    """The plan of a controller that doesn't know where it is."""
    return Plan(np.zeros(wheels), BlindStatus.NO_TORQUE)


def no_correction(wheels: int) -> Correction:
    """What a corrector that wasn't asked has said."""
    return Correction(np.zeros(wheels), np.full(wheels, np.nan), False)


NO_VERDICT = Verdict(0.0, Decision.IDLE, Reason.NO_MEASUREMENT, np.nan, np.nan, np.nan)
