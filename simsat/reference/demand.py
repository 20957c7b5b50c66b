"""What following a reference takes of a spacecraft, known before the flight.

To turn with the reference the wheels hold p = A+ (J w) less the momentum that the craft has, and
push with A+ (J w' + w x J w); what no wheel reaches is along n. Without momentum the reference must
keep n'J w = 0 there: the rest has to be brought by rods, at |b x n| |B| per A m^2.
"""

from dataclasses import dataclass

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.reference.reference import Reference

SAMPLES = 20_000  # of the flight, at most
CLOSE_S = 0.5  # s: half of what the angular acceleration is taken over


@dataclass(frozen=True)
class Demand:
    """The most that following asks for at any time of the flight."""

    rate: float
    """rad/s."""
    momentum_share: Array
    """Of what each wheel can hold, shape (m,); 0 without a limit."""
    torque_share: Array
    """Of what each wheel can give, shape (m,); 0 without a limit."""
    unactuated_momentum: float
    """Largest n'J w, Nms; 0 where every axis has a wheel."""
    unactuated_torque: float
    """Largest change of it, Nm."""


def demand_of(reference: Reference, craft: Spacecraft, duration: float) -> Demand:
    """What a craft without momentum of its own has to do to follow for so many seconds."""
    t = np.linspace(0.0, duration, min(SAMPLES, int(duration) + 2))
    w = reference.rate(t)
    w_dot = (reference.rate(t + CLOSE_S) - reference.rate(t - CLOSE_S)) / (2.0 * CLOSE_S)
    H = w @ craft.J.T
    torque = w_dot @ craft.J.T + np.cross(w, H)
    to_wheels = np.linalg.pinv(craft.A)
    n = np.zeros(3) if craft.unactuated is None else craft.unactuated
    return Demand(
        rate=float(np.linalg.norm(w, axis=1).max()),
        momentum_share=np.abs(H @ to_wheels.T).max(axis=0) / craft.momentum_max,
        torque_share=np.abs(torque @ to_wheels.T).max(axis=0) / craft.torque_max,
        unactuated_momentum=float(np.abs(H @ n).max()),
        unactuated_torque=float(np.abs(torque @ n).max()),
    )


def refuse_too_fast(reference: Reference, craft: Spacecraft, duration: float) -> None:
    """Raise `SettingsError` if the reference turns faster than the wheels can follow."""
    if not reference.moving:
        return
    demand = demand_of(reference, craft, duration)
    for share, what in ((demand.momentum_share, "hold"), (demand.torque_share, "give")):
        wheel = int(np.argmax(share))
        if share[wheel] > 1.0:
            kind = "momentum" if what == "hold" else "torque"
            raise SettingsError(
                f"--reference turns at up to {np.rad2deg(demand.rate):.3g} deg/s: following takes "
                f"{share[wheel]:.3g} times the {kind} that wheel '{craft.wheel_names[wheel]}' can "
                f"{what}"
            )


def told(reference: Reference, craft: Spacecraft, duration: float) -> str:
    """In a sentence: how fast it turns, and what wheels cannot bring; empty if it doesn't move."""
    if not reference.moving:
        return ""
    demand = demand_of(reference, craft, duration)
    sentence = f"the reference turns at up to {np.rad2deg(demand.rate):.3g} deg/s"
    if craft.unactuated is None or demand.rate == 0.0:
        return sentence
    sentence += (
        f" and takes up to {demand.unactuated_momentum:.2g} Nms along the axis without a wheel, "
        f"changing by {demand.unactuated_torque:.2g} Nm: "
    )
    if not craft.rods.count:
        return sentence + "wheels cannot bring it, and there are no rods"
    return sentence + f"rods have to bring it, with {np.max(craft.rods.dipole_max):g} A m^2 each"
