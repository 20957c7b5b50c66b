"""What became of a flight, and why: the cause beside "not converged".

The causes are looked for in the order below, the first that holds is told. All are facts about the
truth: the error's history, the momentum there was, the motors' torques and speeds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from simsat.appraisal.preview import preview
from simsat.control.ground.arrays import Array, Vectors3
from simsat.control.ground.attitude import rotation_matrix
from simsat.control.model.reachable import Reach, reachable
from simsat.flight.loop import Ending, Flight
from simsat.flight.mission import Mission
from simsat.results.metrics import (
    AT_SPEED_LIMIT,
    CONVERGED_BELOW_DEG,
    error_deg,
    minimum_stay_s,
    settling_sample,
)

SATURATED = 0.99  # of the torque limit
OFTEN = 0.3  # of the flight's second half at a limit: a slew is over by then
UNREACHED = np.deg2rad(CONVERGED_BELOW_DEG)  # rad: a rest further off is none at the target


class Outcome(Enum):
    """What became of it; the value is a sentence."""

    SETTLED = "it settled and stayed"
    BROKEN_OFF = "it was broken off"
    LEFT = "it settled and left again"
    MOMENTUM = "the momentum can't be held at the target"
    HORIZON = "the planner's horizon is too short"
    SPEED_LIMIT = "wheels are at their speed limit"
    TORQUE_LIMIT = "wheels are at their torque limit"
    TOO_SHORT = "the flight is too short"
    NOT_SETTLED = "it did not settle, and none of the other causes holds"


@dataclass(frozen=True)
class Explanation:
    """The outcome, and the numbers behind it as a phrase; empty where there is nothing to add."""

    outcome: Outcome
    cause: str = ""


@dataclass(frozen=True)
class Case:
    """A flight that was flown to its end and has not converged."""

    mission: Mission
    flight: Flight
    error: Array
    """At every sample, deg."""


def explain(mission: Mission, flight: Flight) -> Explanation:
    """The outcome of a flight."""
    error = error_deg(flight, mission.target)
    if flight.ending is not Ending.COMPLETE:
        return Explanation(Outcome.BROKEN_OFF)
    if settling_sample(flight, error) is not None:
        return Explanation(Outcome.SETTLED)
    case = Case(mission, flight, error)
    found = (Explanation(outcome, cause(case)) for outcome, cause in CAUSES)
    return next((one for one in found if one.cause), Explanation(Outcome.NOT_SETTLED))


def _left(case: Case) -> str:
    """That it had been below the bound for as long as settling takes, and left."""
    t, below = case.flight.plant.log.t, case.error < CONVERGED_BELOW_DEG
    edges = np.flatnonzero(np.diff(np.concatenate([[False], below, [False]]).astype(int)))
    starts, ends = edges[::2], edges[1::2]
    stayed = t[np.minimum(ends, len(t) - 1)] - t[starts] >= minimum_stay_s(case.flight)
    before_the_end = ends < len(t)
    if not np.any(stayed & before_the_end):
        return ""
    last = np.flatnonzero(stayed & before_the_end)[-1]
    first, left = int(starts[last]), int(ends[last])
    return (
        f"settled at t = {t[first]:.4g} s and left at t = {t[left]:.4g} s{_push(case, first, left)}"
    )


def _push(case: Case, first: int, last: int) -> str:
    """The external torque along the axis without a wheel between two samples."""
    craft = case.flight.plant.model.spacecraft
    n, t = craft.unactuated, case.flight.plant.log.t
    if n is None:
        return ""
    along = _momentum_N(case)[[first, last]] @ (rotation_matrix(case.mission.target) @ n)
    torque = float(along[1] - along[0]) / float(t[last] - t[first])
    return f", pushed along the axis without a wheel by {torque:.2g} Nm in the mean"


def _momentum(case: Case) -> str:
    """That no attitude near the target can be held with the momentum at the end."""
    craft = case.flight.plant.model.spacecraft
    reach = reachable(craft, case.mission.target, _momentum_N(case)[-1])
    if reach.reach is Reach.TARGET or reach.angle < UNREACHED:
        return ""
    return reach.reason.rstrip(".")


def _horizon(case: Case) -> str:
    seen = preview(case.mission)
    if seen.horizon is None or seen.horizon >= seen.braking:
        return ""
    return (
        f"the horizon of {seen.horizon:.3g} s is shorter than stopping takes, {seen.braking:.3g} s"
    )


def _speed_limit(case: Case) -> str:
    plant = case.flight.plant
    limit = AT_SPEED_LIMIT * plant.model.spacecraft.speed_max
    return _often(np.abs(plant.wheel_speeds) >= limit, "speed limit")


def _torque_limit(case: Case) -> str:
    plant = case.flight.plant
    limit = SATURATED * plant.model.spacecraft.torque_max
    return _often(np.abs(plant.torques) >= limit, "torque limit")


def _often(at_limit: NDArray[np.bool_], what: str) -> str:
    share = float(at_limit[len(at_limit) // 2 :].any(axis=1).mean())
    return f"a wheel was at its {what} for {100 * share:.0f} % of the second half" * (share > OFTEN)


def _too_short(case: Case) -> str:
    seen, needed = preview(case.mission), minimum_stay_s(case.flight)
    if seen.duration >= seen.slew + needed:
        return ""
    return (
        f"the flight of {seen.duration:.3g} s is shorter than a slew of about {seen.slew:.3g} s "
        f"and {needed:.3g} s of rest"
    )


CAUSES: tuple[tuple[Outcome, Callable[[Case], str]], ...] = (
    (Outcome.TOO_SHORT, _too_short),
    (Outcome.LEFT, _left),
    (Outcome.MOMENTUM, _momentum),
    (Outcome.HORIZON, _horizon),
    (Outcome.SPEED_LIMIT, _speed_limit),
    (Outcome.TORQUE_LIMIT, _torque_limit),
)


def _momentum_N(case: Case) -> Vectors3:
    """Angular momentum at every sample, inertial axes, Nms, appendages apart."""
    plant = case.flight.plant
    H_B = plant.model.spacecraft.angular_momentum(plant.rates, plant.wheel_speeds)
    momentum: Vectors3 = np.einsum("kij,kj->ki", rotation_matrix(plant.attitudes), H_B)
    return momentum
