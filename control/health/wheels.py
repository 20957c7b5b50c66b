"""Whether each rotor follows its motor: the impulse asked against the spin momentum gained.

    r = impulse of the command - (p_1 - p_0)       p = Js (Omega + A' omega)

No torque on the body enters p, so that of a sound wheel r is friction's and the noise's. A wheel
has failed if it misses the better part of a strong impulse twice running, or if its momentum leaps
as no motor can move it, which is what a rotor does that locks. Friction of up to a quarter of the
torque limit, a late sample and a coarse tachometer stay below that. (Residuals of an actuator's own
dynamics: Isermann, Fault-Diagnosis Systems, section 10.2.)
"""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import WheelVector
from ..ground.spacecraft import Spacecraft
from ..interface.measurement import Measurement
from ..model.momentum import spin_momentum
from ..model.ramp import ramped_impulse

STRONG = 0.25  # of what the largest torque gives in a period: ten times a bearing's friction is 0.2
MISSED = 0.5  # of the impulse; a wheel that gives the larger part is flown on
RUNNING = 2  # periods: one may be a late sample at a reversal
LEAP = 1.5  # of what the largest torque gives in a period: beyond a reversal's ramp
AT_REST = 2.0  # rad/s, 19 rpm: a locked rotor's tachometer reads noise
NEAR_LIMIT = 0.99  # of the speed limit, where a motor's torque is cut


class Fate(Enum):
    """What became of a wheel; the value is a sentence."""

    COASTS = "its motor moves it no more: it keeps its momentum"
    LOCKED = "its rotor is locked to the hub: it is a part of the body"


@dataclass(frozen=True)
class WheelMonitor:
    """What is remembered of the wheels."""

    torque_before: WheelVector
    """Torque commanded over the period before the one that ended last, Nm."""
    missed: NDArray[np.int64]
    """Periods running in which each wheel missed a strong impulse."""
    fates: tuple[Fate | None, ...]
    """Of each wheel; None while it is sound."""

    @property
    def sound(self) -> tuple[int, ...]:
        """The wheels that are left."""
        return tuple(i for i, fate in enumerate(self.fates) if fate is None)


def all_sound(wheels: int) -> WheelMonitor:
    """The monitor at the start."""
    return WheelMonitor(np.zeros(wheels), np.zeros(wheels, np.int64), (None,) * wheels)


def watched(
    monitor: WheelMonitor, measurement: Measurement, craft: Spacecraft, period: float
) -> WheelMonitor:
    """The monitor after a measurement as it was sensed; a failed wheel stays failed.

    `period` (s) is the control period: over a shorter history nothing can be said.
    """
    history, torque = measurement.history, measurement.torque
    after = replace(monitor, torque_before=torque)
    if abs(float(history.t[-1] - history.t[0]) - period) > 1e-6:
        return after
    p = spin_momentum(craft, history.omega[[0, -1]], history.wheel_speed[[0, -1]])
    asked = ramped_impulse(torque, monitor.torque_before, craft.torque_rate_max, period)
    residual = asked - (p[1] - p[0])
    largest = period * np.where(np.isinf(craft.torque_max), np.abs(torque), craft.torque_max)
    cut = np.abs(history.wheel_speed).max(axis=0) >= NEAR_LIMIT * craft.speed_max
    strong = np.maximum(MISSED * np.abs(asked), STRONG * largest)
    misses = (residual * np.sign(asked) > strong) & ~cut & (largest > 0.0)
    leaps = (np.abs(residual) > LEAP * largest) & ~cut & (largest > 0.0)
    resting = np.abs(history.wheel_speed[-1]) < AT_REST
    missed = np.where(misses, monitor.missed + 1, 0)
    locks = (leaps & resting) | ((missed >= RUNNING) & resting)
    fates = tuple(
        fate or _fate(bool(locks[i]), bool(missed[i] >= RUNNING))
        for i, fate in enumerate(monitor.fates)
    )
    return replace(after, missed=missed, fates=fates)


def _fate(locked: bool, failed: bool) -> Fate | None:
    if locked:
        return Fate.LOCKED
    return Fate.COASTS if failed else None
