"""From a torque wanted to the dipoles that come closest to it, within the rods' limits.

    tau = (D m) x B

lies across the field B, whatever the rods' axes D: two components can be had at a time. Along one
direction n the torque t is met first, what is left of the rods comes closest to the rest:

    minimise W^2 (n'tau - n't)^2 + |tau - t|^2 + eps^2 |m / m_max|^2        subject to |m| <= m_max

where W says how much torque across n may come with what is asked along it: the wheels have to take
that up, and with the field close to n it is many times as much. With b = B/|B| and three rods the
torque plane splits into e1 = (n - b b'n) / |b x n|, the most along n that can be had, and e2 = b x
n / |b x n|, which has no part along n: the first term takes e1, the second e2. The bounded least
squares are SciPy's (Stark and Parker's BVLS).
"""

import numpy as np
from scipy.optimize import lsq_linear

from ..ground.arrays import Array, RodVector, Vector3
from ..ground.magnetorquers import Magnetorquers

PRIORITY = 10.0  # W: half is met along n where that costs ten times as much across it
EFFORT = 1e-3  # eps, of full dipole against a torque of |B| m_max: picks one of equal answers
NO_FIELD = 1e-12  # T: below, no torque is to be had; interplanetary fields are a thousand times it


def torque_map(rods: Magnetorquers, field_B: Vector3) -> Array:
    """d tau / d m in a field (T, body axes), Nm per A m^2, body axes, shape (3, k)."""
    return np.cross(rods.axes.T, field_B).T


def capability(rods: Magnetorquers, field_B: Vector3, direction: Vector3) -> float:
    """The largest torque (Nm) along a unit direction that the rods can give."""
    return float(np.abs(direction @ torque_map(rods, field_B)) @ rods.dipole_max)


def allocate(
    rods: Magnetorquers, field_B: Vector3, torque: Vector3, first: Vector3 | None = None
) -> RodVector:
    """Dipoles, A m^2, within their limits, for a torque (Nm, body axes) wanted; its component along
    the unit direction `first`, if there is one, before all else."""
    strength = float(np.linalg.norm(field_B))
    if strength < NO_FIELD or rods.count == 0:
        return np.zeros(rods.count)
    size = strength * float(np.max(rods.dipole_max))
    by_share = torque_map(rods, field_B) * rods.dipole_max / size
    rows, wanted = [by_share, EFFORT * np.eye(rods.count)], [torque / size, np.zeros(rods.count)]
    if first is not None:
        most = capability(rods, field_B, first)
        along = float(np.clip(first @ torque, -most, most)) / size
        rows.append(PRIORITY * (first @ by_share)[None, :])
        wanted.append(np.array([PRIORITY * along]))
    solution = lsq_linear(np.vstack(rows), np.concatenate(wanted), (-1.0, 1.0), method="bvls")
    return np.clip(solution.x, -1.0, 1.0) * rods.dipole_max
