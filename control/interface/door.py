"""The door of a controller: which measurements it is shown, and which are refused.

Every measurement passes here before any layer sees it, so that no layer has to guard its memory: a
refused one is flown through without (see `blind`), and nothing of it is kept. What passes
is finite, small enough for any arithmetic, of this instant, and its attitude is a rotation. A
number that is wrong but could be right is not told from a right one: that takes a filter.
"""

from dataclasses import replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from .measurement import Fix, History, Measurement, Sighting

UNIT_SLACK = 1e-6  # of |q|: single precision is off by 1e-7
# The others are for the benchmark; its second stands for the craft's own (`ground.units`).
TIME_SLACK = 1e-3  # s: a time stamp's jitter; a sample is 50 ms
RATE_MAX = 1e3  # rad/s, 10,000 rpm: no spacecraft holds together, and squares are far from overflow
WHEEL_SPEED_MAX = 1e5  # rad/s, a million rpm: likewise for a wheel
AGE_MAX = 60.0  # s: no instrument is as late
FIELD_MAX = 1e-3  # T: the Earth's is 7e-5 at most
TURNS = 1e-6  # rad/s: a body that turns faster than this changes its attitude's digits in a period


class Refusal(Enum):
    """Why a measurement is refused, as a sentence."""

    INCOMPLETE = "A quantity is missing, is no number or has the wrong number of components."
    NOT_FINITE = "A number is not finite."
    NO_ATTITUDE = "The attitude is not a unit quaternion."
    IMPOSSIBLE = "A rate is beyond anything that turns."
    WRONG_TIME = "Its time is not that of the controller's clock."
    STUCK = "It repeats the last one to the last digit although it says that the body turns."


def admit(
    measurement: Measurement,
    clock: float,
    period: float,
    last: Measurement | None,
    wheels: int,
    second: float = 1.0,
) -> Measurement | Refusal:
    """The measurement as the controller may see it, or why it may not.

    `clock` is the controller's time and `period` its control period, s; `last` the measurement that
    was admitted last; `second` the craft's own, s. Samples of the history that are unsound are left
    out; a measurement without such samples is passed on as it is. A magnetic field that can't be is
    left out: the craft can be flown without.
    """
    if not _complete(measurement, wheels):
        return Refusal.INCOMPLETE
    now = measurement.omega, measurement.wheel_speed
    numbers = (measurement.t, measurement.q, measurement.torque, *now)
    if not all(np.isfinite(x).all() for x in numbers):
        return Refusal.NOT_FINITE
    if not abs(_norm(measurement.q) - 1.0) <= UNIT_SLACK:
        return Refusal.NO_ATTITUDE
    if not _possible(*now, second).all():
        return Refusal.IMPOSSIBLE
    if abs(measurement.t - clock) > TIME_SLACK * second:
        return Refusal.WRONG_TIME
    if last is not None and _stuck(measurement, last, second):
        return Refusal.STUCK
    sound = _with_sound_aids(_with_sound_field(measurement), second)
    return _with_sound_history(sound, clock - period, second)


def _with_sound_field(measurement: Measurement) -> Measurement:
    if measurement.field_B is None:
        return measurement
    B = np.asarray(measurement.field_B)
    possible = B.shape == (3,) and B.dtype.kind == "f" and (np.abs(B) <= FIELD_MAX).all()
    return measurement if possible else replace(measurement, field_B=None)


def _complete(measurement: Measurement, wheels: int) -> bool:
    history = measurement.history
    samples = np.shape(history.t)
    shapes = (
        (measurement.t, ()),
        (measurement.q, (4,)),
        (measurement.omega, (3,)),
        (measurement.wheel_speed, (wheels,)),
        (measurement.torque, (wheels,)),
        (history.t, samples),
        (history.omega, (*samples, 3)),
        (history.wheel_speed, (*samples, wheels)),
    )
    fit = all(np.shape(x) == shape for x, shape in shapes)
    return fit and len(samples) == 1 and all(np.asarray(x).dtype.kind == "f" for x, _ in shapes)


def _norm(q: Array) -> float:
    """|q|, infinite rather than a warning where it overflows."""
    return float(np.hypot(np.hypot(q[0], q[1]), np.hypot(q[2], q[3])))


def _possible(omega: Array, wheel_speed: Array, second: float) -> NDArray[np.bool_]:
    """Whether rates are finite and below what anything turns at, shape (...)."""
    slow = (np.abs(omega) <= RATE_MAX / second).all(axis=-1)  # false for NaN
    return np.asarray(slow & (np.abs(wheel_speed) <= WHEEL_SPEED_MAX / second).all(axis=-1))


def _stuck(now: Measurement, last: Measurement, second: float) -> bool:
    """Whether nothing has changed although the body says it turns."""
    same = np.array_equal(now.q, last.q) and np.array_equal(now.omega, last.omega)
    turns = bool(np.any(np.abs(now.omega) > TURNS / second))
    return same and np.array_equal(now.wheel_speed, last.wheel_speed) and turns


def _with_sound_aids(measurement: Measurement, second: float) -> Measurement:
    """The measurement with those of its fixes and sightings that can be true."""
    fixes = tuple(fix for fix in measurement.fixes if _can_be_fix(fix, measurement.t, second))
    now = measurement.t
    sightings = tuple(s for s in measurement.sightings if _can_be_sighting(s, now, second))
    if len(fixes) + len(sightings) == len(measurement.fixes) + len(measurement.sightings):
        return measurement
    return replace(measurement, fixes=fixes, sightings=sightings)


def _can_be_fix(fix: Fix, now: float, second: float) -> bool:
    """Whether it is a rotation of the past with an error that has a size."""
    if np.shape(fix.q) != (4,) or np.shape(fix.covariance) != (3, 3):
        return False
    past = bool(np.isfinite(fix.t)) and now - AGE_MAX <= fix.t <= now + TIME_SLACK * second
    sized = np.isfinite(fix.covariance).all() and bool((np.diag(fix.covariance) > 0.0).all())
    return past and abs(_norm(fix.q) - 1.0) <= UNIT_SLACK and bool(sized)


def _can_be_sighting(sighting: Sighting, now: float, second: float) -> bool:
    """Whether it is two directions of the past with an error that has a size."""
    directions = sighting.direction_B, sighting.direction_N
    if any(np.shape(direction) != (3,) for direction in directions):
        return False
    past = (
        bool(np.isfinite(sighting.t)) and now - AGE_MAX <= sighting.t <= now + TIME_SLACK * second
    )
    unit = all(abs(_norm(np.append(d, 0.0)) - 1.0) <= UNIT_SLACK for d in directions)
    return past and unit and 0.0 < sighting.deviation < np.inf


def _with_sound_history(measurement: Measurement, since: float, second: float) -> Measurement:
    """The measurement with the sound samples since the last instant: finite, possible, each later
    than the one before."""
    history, t = measurement.history, measurement.history.t
    slack = TIME_SLACK * second
    in_period = (t >= since - slack) & (t <= measurement.t + slack)
    sound = in_period & _possible(history.omega, history.wheel_speed, second)
    latest = np.maximum.accumulate(np.where(sound, t, -np.inf))
    sound[1:] &= t[1:] > latest[:-1]
    if sound.size and sound.all():
        return measurement
    kept = History(t[sound], history.omega[sound], history.wheel_speed[sound])
    if not sound.any():
        kept = History(
            np.array([measurement.t]), measurement.omega[None], measurement.wheel_speed[None]
        )
    return replace(measurement, history=kept)
