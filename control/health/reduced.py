"""A craft flown without some of its wheels, and what it senses, told in terms of those left.

A rotor that is locked is a part of the body: J has it already. One that coasts keeps its momentum
p = Js (Omega + a'omega), so that it adds nothing to the body's inertia, J - Js a a', but carries
a p along. What of that lies in the plane or space of the wheels that are left is told as momentum
of theirs, which is exact; what lies outside stays untold: no wheel can take it up, and the craft
can't rest while it turns.
"""

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from ..ground.arrays import Array, Vectors3, WheelVectors
from ..ground.spacecraft import Spacecraft
from ..interface.measurement import Measurement
from .wheels import Fate


def reduced(craft: Spacecraft, fates: Sequence[Fate | None]) -> Spacecraft:
    """The craft with the wheels that are left."""
    kept = [i for i, fate in enumerate(fates) if fate is None]
    coasting = [i for i, fate in enumerate(fates) if fate is Fate.COASTS]
    A = craft.A[:, coasting]
    values = {
        each.name: getattr(craft, each.name)[kept]
        for each in fields(craft)
        if each.name in ("Js", "torque_max", "torque_rate_max", "speed_max", "viscous", "coulomb")
    }
    return replace(
        craft,
        **values,
        J=craft.J - (A * craft.Js[coasting]) @ A.T,
        A=craft.A[:, kept],
        wheel_names=tuple(craft.wheel_names[i] for i in kept),
        envelopes=tuple(craft.envelopes[i] for i in kept) if craft.envelopes else (),
        fingerprint="",
    )


def narrowed(
    measurement: Measurement, craft: Spacecraft, fates: Sequence[Fate | None]
) -> Measurement:
    """The measurement in terms of the wheels that are left."""
    kept = [i for i, fate in enumerate(fates) if fate is None]
    history, origin = measurement.history, measurement.origin
    speeds = _told(measurement.omega, measurement.wheel_speed, craft, fates)
    return replace(
        measurement,
        wheel_speed=speeds,
        torque=measurement.torque[kept],
        history=replace(
            history, wheel_speed=_told(history.omega, history.wheel_speed, craft, fates)
        ),
        origin=None if origin is None else narrowed(origin, craft, fates),
    )


def _told(
    omega: Vectors3, wheel_speed: WheelVectors, craft: Spacecraft, fates: Sequence[Fate | None]
) -> WheelVectors:
    """Speeds of the wheels that are left, with the coasting rotors' momentum on top."""
    kept = [i for i, fate in enumerate(fates) if fate is None]
    coasting = [i for i, fate in enumerate(fates) if fate is Fate.COASTS]
    speeds: Array = wheel_speed[..., kept]
    if not coasting:
        return speeds
    A, Js = craft.A[:, coasting], craft.Js[coasting]
    carried = (Js * (wheel_speed[..., coasting] + omega @ A)) @ A.T
    return speeds + carried @ np.linalg.pinv(craft.A[:, kept]).T / craft.Js[kept]


def widened(values: Array, fates: Sequence[Fate | None]) -> Array:
    """A value of each wheel left, zero for the others."""
    full = np.zeros(len(fates))
    full[[i for i, fate in enumerate(fates) if fate is None]] = values
    return full
