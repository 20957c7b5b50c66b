"""What a supervisor answers."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum


class Decision(Enum):
    """What became of the correction; the value is a sentence."""

    ACCEPTED = "the correction acts in full"
    ATTENUATED = "a share of the correction acts"
    REJECTED = "the correction is left out and the planned torque acts alone"
    IDLE = "there is no correction to judge"


class Reason(Enum):
    """Why; the value is a sentence."""

    SAFE = "the certificate falls in the worst case considered"
    LIMITED = "a larger share could let the certificate rise"
    PLAN_RISES = (
        "the certificate need not fall even without the correction, so nothing may be added"
    )
    CORRECTION_RISES = "every share that was tried could let the certificate rise"
    NOT_FINITE = "the correction is not a finite number"
    OFF = "the correction is switched off near the target"
    NO_PLAN = "the planner has no solution to judge the correction by"
    NO_MEASUREMENT = "the measurement was refused, so that there is nothing to correct"


@dataclass(frozen=True)
class Verdict:
    """One step's answer and the numbers behind it.

    The certificate is the energy V of `lyapunov` (rates in W) for the faithful and the sound rule,
    and the planner's own cost (rates per second) for the value rule.
    """

    alpha: float
    """Share of the correction that acts, 0 to 1."""
    decision: Decision
    reason: Reason
    certificate: float
    """The certificate now."""
    rate: float
    """Its rate under the planned torque alone."""
    rate_bound: float
    """What the rule's test holds its rate to with alpha: not above zero unless rejected."""
    signals: Mapping[str, float] = field(default_factory=dict)
    """Anything else worth a curve in the recording, by name with its unit."""


def judged(alpha: float, certificate: float, rate: float, rate_bound: float) -> Verdict:
    """Verdict whose decision and reason follow from the share and the rate of the plan alone."""
    if alpha >= 1.0:
        decision, reason = Decision.ACCEPTED, Reason.SAFE
    elif alpha > 0.0:
        decision, reason = Decision.ATTENUATED, Reason.LIMITED
    else:
        decision = Decision.REJECTED
        reason = Reason.PLAN_RISES if rate_bound > 0.0 else Reason.CORRECTION_RISES
    return Verdict(alpha, decision, reason, certificate, rate, rate_bound)


def refused(reason: Reason, certificate: float, rate: float) -> Verdict:
    """Verdict on what can't be judged."""
    return Verdict(0.0, Decision.REJECTED, reason, certificate, rate, rate)


def idle(verdict: Verdict) -> Verdict:
    """The same figures, of a step whose correction is switched off."""
    return replace(verdict, alpha=0.0, decision=Decision.IDLE, reason=Reason.OFF)
