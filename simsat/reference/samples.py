"""Attitudes over time from a file, made into a curve."""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternions
from simsat.control.ground.errors import SettingsError
from simsat.control.reference.reference import Curve

FEWEST = 4  # samples: a cubic has four numbers
LONGER = 10.0  # times the usual interval: a gap
FARTHEST_DEG = 90.0  # between samples: beyond, the way between them is a guess
UNIT = 1e-3  # off unit length: three digits are still an attitude
EDGE_S = 1e-3  # stamps of a message are kept to a millisecond


def curve_through(name: str, t: Array, q: Quaternions, duration: float) -> Curve:
    """The curve through attitudes q (k, 4) at times t (k,), s, which must cover the flight.

    Raises `SettingsError` in one sentence on stamps that don't rise, numbers that are no attitude,
    a gap, attitudes too far apart, or a flight that begins before them or ends after.
    """
    if len(t) < FEWEST:
        raise SettingsError(f"{name} has {len(t)} attitudes, {FEWEST} are the least")
    if not np.isfinite(t).all() or not np.isfinite(q).all():
        raise SettingsError(f"{name} holds a number that isn't finite")
    size = np.linalg.norm(q, axis=1)
    if np.any(np.abs(size - 1.0) > UNIT):
        row = int(np.argmax(np.abs(size - 1.0)))
        raise SettingsError(
            f"{name}: the attitude at t = {t[row]:g} s has length {size[row]:.4g}, it must be a "
            "unit quaternion"
        )
    _refuse_gaps(name, t)
    q = attitude.continuous(attitude.normalized(q))
    _refuse_leaps(name, t, q)
    if t[0] > EDGE_S or t[-1] < duration - EDGE_S:
        raise SettingsError(
            f"{name} covers {t[0]:g} to {t[-1]:g} s of the flight, which lasts from 0 to "
            f"{duration:g} s"
        )
    spline = CubicSpline(t, q)
    slope = spline.derivative()
    first, last = float(t[0]), float(t[-1])  # beyond them the attitude stays as it is
    return Curve(
        lambda s: spline(np.clip(s, first, last)),
        lambda s: np.where(_within(s, first, last), slope(np.clip(s, first, last)), 0.0),
    )


def _within(t: float | Array, first: float, last: float) -> NDArray[np.bool_]:
    inside: NDArray[np.bool_] = ((np.asarray(t) >= first) & (np.asarray(t) <= last))[..., None]
    return inside


def _refuse_gaps(name: str, t: Array) -> None:
    step = np.diff(t)
    if not np.all(step > 0.0):
        row = int(np.argmin(step))
        raise SettingsError(
            f"{name}: times must rise, but {t[row + 1]:g} s follows on {t[row]:g} s"
        )
    usual = float(np.median(step))
    if step.max() > LONGER * usual:
        row = int(np.argmax(step))
        raise SettingsError(
            f"{name} has a gap from {t[row]:g} to {t[row + 1]:g} s, where attitudes are "
            f"{usual:g} s apart elsewhere"
        )


def _refuse_leaps(name: str, t: Array, q: Quaternions) -> None:
    apart = np.rad2deg(attitude.error_angle(q[1:], q[:-1]))
    if apart.max() > FARTHEST_DEG:
        row = int(np.argmax(apart))
        raise SettingsError(
            f"{name}: from {t[row]:g} to {t[row + 1]:g} s the attitude turns by {apart[row]:.0f} "
            f"deg, more than {FARTHEST_DEG:g} between two samples says no way"
        )
