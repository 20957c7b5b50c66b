"""The energy V that the paper's supervisor watches, and its rate.

With q = q_BT (the body relative to the target, scalar first, so that the paper's
q_e = q^-1 (x) q_ref has q_e0 = q_0 and q_ev = -q_v) and q_0' = -1/2 q_v.w:

    squared  V2 = 1/2 w'J w + (k/2)(1 - q_0^2)    V2' = w'tau + (k/2) q_0 q_v'w
    linear   V1 = 1/2 w'J w + k (1 - q_0)         V1' = w'tau + (k/2) q_v'w
    printed  V1 with the rate of V2, which is what the paper prints

The gyroscopic torque w x H does no work, so it drops out of every rate. For a hub with wheels the
torque -A u accelerates J_hub = J - A Js A', and only with that inertia is the rate exact; the paper
writes J, which differs by Js/J (a thousandth). No inertia enters a rate: the paper's remark that
corrections are rejected "because of the nominal inertia" cannot hold for its own rule.

V2 is the default: it is the same for q and -q (no unwinding) and its rate is its own. `printed`
decides exactly as `squared` does, because the rules see the rate alone.

Every function takes a batch in the leading axes. Source: the paper, section 2; Schaub and Junkins,
Analytical Mechanics of Space Systems, 4th ed., section 8.3.
"""

from enum import Enum

import numpy as np

from ..ground.arrays import Array, Matrices3, Quaternions, Vectors3


class Energy(Enum):
    """Which V is watched."""

    SQUARED = "squared"
    LINEAR = "linear"
    PRINTED = "printed"


def dot(a: Vectors3, b: Vectors3) -> Array:
    """a.b along the last axis."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def energy(
    form: Energy, q_BT: Quaternions, omega: Vectors3, J_hub: Matrices3, gain: float
) -> Array:
    """V in joule; omega in body axes (rad/s), J_hub in kg m^2, gain k in Nm."""
    kinetic = 0.5 * np.einsum("...i,...ij,...j->...", omega, J_hub, omega)
    scalar = q_BT[..., 0]
    attitude = 0.5 * (1.0 - scalar**2) if form is Energy.SQUARED else 1.0 - scalar
    return np.asarray(kinetic + gain * attitude)


def energy_rate(
    form: Energy, q_BT: Quaternions, omega: Vectors3, torque: Vectors3, gain: float
) -> Array:
    """V' in watt under a torque on the hub (body axes, Nm); needs no inertia."""
    scalar = np.ones_like(q_BT[..., 0]) if form is Energy.LINEAR else q_BT[..., 0]
    return dot(omega, torque + 0.5 * gain * scalar[..., None] * q_BT[..., 1:])
