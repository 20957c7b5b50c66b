"""What is known of a flight before it is flown: its times, what its momentum lets it reach, and
what about them will go wrong."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from simsat.control.ground.attitude import error_angle, rotation_matrix
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.guidance.minimum_time import expected_duration
from simsat.control.model.momentum import MomentumModel
from simsat.control.model.reachable import Reachable, reachable
from simsat.flight.controllers import CONTROLLERS
from simsat.flight.mission import Mission

WHOLE_SLEW = "nmpc-learned"  # the controller whose plans have no horizon
LONGEST_PERIOD = 2.0
"""Own seconds; with 2.5 `nmpc` settles `three_wheel` after 17.8 s, with 0.25 to 2 after 14.3 to
15.3 (125 deg)."""
LONGEST_PERIOD_LOOPING = 0.7
"""The same of the baseline on a craft that has to loop: with 0.75 own seconds and more `nmpc` never
settles `two_wheel`."""
SHORTEST_PERIOD = 0.1
"""Own seconds; with 0.1 `nmpc` no longer settles `two_wheel`, with 0.05 half of the time."""


@dataclass(frozen=True)
class Preview:
    """Times in s."""

    natural_time: float
    """sqrt(J / u_max): everything a craft does takes so many of these."""
    own_second: float
    """The natural time over that of the benchmark."""
    period: float
    horizon: float | None
    """What the baseline's plans look ahead; None for a controller without a horizon."""
    duration: float
    slew: float
    """About how long the slew will take."""
    braking: float
    """How long stopping takes, from the start's rates or from the middle of the slew."""
    longest_period: float
    """Beyond, the controller is known to do worse."""
    reach: Reachable
    """What the momentum at the start allows."""


def preview(mission: Mission) -> Preview:
    """What is known of a mission, by the true numbers of its craft."""
    settings, timing = mission.brief.settings, mission.timing
    has_horizon = settings.controller in CONTROLLERS and settings.controller != WHOLE_SLEW
    slew, braking = _slew(mission)
    loops = has_horizon and mission.believed.actuation_rank < 3
    return Preview(
        natural_time=timing.units.natural_time,
        own_second=timing.units.time,
        period=timing.period_s,
        horizon=settings.nmpc.horizon * timing.period_s if has_horizon else None,
        duration=timing.duration_s,
        slew=slew,
        braking=braking,
        longest_period=(LONGEST_PERIOD_LOOPING if loops else LONGEST_PERIOD) * timing.units.time,
        reach=reach_at_start(mission),
    )


def reach_at_start(mission: Mission) -> Reachable:
    """What the momentum at the start allows."""
    craft, start = mission.model.spacecraft, mission.start
    H_B = craft.angular_momentum(start.omega, start.wheel_speed)
    return reachable(craft, mission.target, rotation_matrix(start.q) @ H_B)


def warnings(seen: Preview) -> Iterator[str]:
    """What will go wrong, a sentence each."""
    if seen.horizon is not None and seen.horizon < seen.braking:
        stages = int(np.ceil(seen.braking / seen.period))
        yield (
            f"the horizon of {seen.horizon:.3g} s is shorter than the {seen.braking:.3g} s that "
            f"stopping takes: --nmpc.horizon {stages} or more sees it"
        )
    if seen.period > seen.longest_period:
        yield (
            f"the control period of {seen.period:.3g} s is long for a craft with a natural time of "
            f"{seen.natural_time:.3g} s: {0.5 * seen.own_second:.2g} s is usual, beyond "
            f"{seen.longest_period:.2g} s it flies worse"
        )
    if seen.period < SHORTEST_PERIOD * seen.own_second:
        yield (
            f"the control period of {seen.period:.3g} s is short for a craft with a natural time of"
            f" {seen.natural_time:.3g} s: plans cost more and reach less far, "
            f"{0.5 * seen.own_second:.2g} s is usual"
        )
    if seen.duration < seen.slew:
        yield (
            f"the flight of {seen.duration:.3g} s may be too short for a slew of about "
            f"{seen.slew:.3g} s"
        )


def _slew(mission: Mission) -> tuple[float, float]:
    """(duration, braking time), s: turning from rest to rest at one wheel's torque and at most one
    wheel's momentum, or on two wheels by a loop; and the start's rates taken up."""
    units = mission.timing.units
    craft, start = mission.model.spacecraft.in_units(units), mission.start
    torque, size = float(np.min(craft.torque_max)), float(np.trace(craft.J)) / 3.0
    turn = float(error_angle(start.q, mission.target))
    fastest = float(np.min(craft.momentum_max)) / size
    rate = min(np.sqrt(turn * torque / size), fastest) if np.isfinite(torque) else fastest
    braking = size * rate / torque if np.isfinite(rate) else 0.0
    slew = turn / rate + braking if rate > 0.0 else 0.0
    if craft.actuation_rank < 3 and np.isfinite(torque):
        model = MomentumModel(craft, craft.J, np.array([0.0, 0.0, 0.0]))
        slew = max(slew, expected_duration(model, start.q, mission.target, craft.torque_max))
    stopping = _stopping(craft, start.omega / units.rate)
    return float(slew * units.time), float(max(braking, stopping) * units.time)


def _stopping(craft: Spacecraft, omega: np.ndarray) -> float:
    """Time in which the wheels take up the body's momentum, in the craft's units."""
    wanted = np.abs(np.linalg.pinv(craft.A) @ (craft.J @ omega))
    return float(np.max(wanted / craft.torque_max))
