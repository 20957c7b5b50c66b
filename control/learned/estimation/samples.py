"""What the filter is fed: measurements at rising times, with the attitudes in between."""

from dataclasses import dataclass

import numpy as np

from ...ground.arrays import Array, Quaternion, Quaternions, Vector3, Vectors3, WheelVectors
from ...ground.attitude import multiply, rotation_matrix
from ...ground.spacecraft import Spacecraft
from ...ground.turn import rotation_by
from ...model.momentum import spin_momentum

ENOUGH = 24  # samples: their noise is then known to some 15 %, by 20 fourth differences an axis

UNITS: Quaternions = np.asarray(np.eye(4))
"""The four units 1, i, j, k as rows."""


@dataclass(frozen=True)
class Samples:
    """Measurements at rising times, the latest one last."""

    t: Array
    q: Quaternions
    """Shape (k, 4)."""
    omega: Vectors3
    """Shape (k, 3)."""
    wheel_momentum: Vectors3
    """A (Js * Omega), body axes, Nms, shape (k, 3)."""
    known_torque: Vectors3
    """External torque that is known, over the time before each sample: that of magnetic rods;
    inertial axes, Nm, shape (k, 3)."""
    spin: WheelVectors
    """Spin momenta of the rotors, Nms, shape (k, m)."""


def joined(before: Samples, after: Samples) -> Samples:
    """The last samples of both, as many as tell the noise: those `before` only where it takes
    them."""
    missing = max(ENOUGH - len(after.t), 0)
    older = before.t < after.t[0] - 1e-9
    if missing == 0 or not np.any(older):
        return after
    pairs = zip(vars(before).values(), vars(after).values(), strict=True)
    return Samples(*(np.concatenate([one[older][-missing:], two]) for one, two in pairs))


def samples_of(
    q: Quaternion,
    t: Array,
    omega: Vectors3,
    wheel_speed: WheelVectors,
    spacecraft: Spacecraft,
    moment_B: Vector3 | None = None,
    field_B: Vector3 | None = None,
) -> Samples:
    """Samples from a history whose last attitude is q, in which the rods had the dipole `moment_B`
    (A m^2, body axes); `field_B` is the magnetic field at the last sample (T, body axes)."""
    wheel_momentum = (wheel_speed * spacecraft.Js) @ spacecraft.A.T
    attitudes = integrate_back(q, t, omega)
    known: Vectors3 = np.asarray(np.zeros((len(t), 3)))
    if moment_B is not None and field_B is not None:
        known = np.cross(rotation_matrix(attitudes) @ moment_B, rotation_matrix(q) @ field_B)
    spin = spin_momentum(spacecraft, omega, wheel_speed)
    return Samples(t, attitudes, omega, wheel_momentum, known, spin)


def integrate_back(q: Quaternion, t: Array, omega: Vectors3) -> Quaternions:
    """Attitudes at times t that end in q, from the rates in between, shape (k, 4).

    Trapezium of the rates: over half a second the error stays below 1e-6 rad.
    """
    turns = rotation_by(-0.5 * np.diff(t)[:, None] * (omega[1:] + omega[:-1]))
    by = multiply(UNITS, turns[:, None])  # rows: units (x) turn, so q (x) turn = q @ by
    attitudes = [q]
    for turn in by[::-1]:
        attitudes.append(attitudes[-1] @ turn)
    return np.stack(attitudes[::-1])
