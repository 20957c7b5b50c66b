"""From a torque wanted to the dipoles that come closest to it, within the rods' limits.

    tau = (D m) x B

lies across the field B, whatever the rods' axes D: two components can be had at a time. Along one
direction the torque is met first, what is left of the rods comes closest to the rest:

    minimise W^2 (n'tau - n't)^2 / |n'dtau/dm|^2 + |tau - t|^2 + eps^2 |m / m_max|^2,   |m| <= m_max

With b = B/|B| and three rods the torque plane splits into e1 = (n - b b'n) / |b x n|, the most
along n that can be had, and e2 = b x n / |b x n|, which has no part along n: the first term takes
e1, the second e2. The bounded least squares are SciPy's (Stark and Parker's BVLS).
"""

import numpy as np
from scipy.optimize import lsq_linear

from ..ground.arrays import Array, Vector3

PRIORITY = 300.0  # W: what is met first is missed by 1e-5 of what the rest would like
LEAST_PART = 1e-6  # of |B| m_max: rods that reach less along the direction don't reach it
EFFORT = 1e-3  # eps, of full dipole against a torque of |B| m_max: picks one of equal answers
NO_FIELD = 1e-12  # T: below, no torque is to be had; interplanetary fields are a thousand times it


def rod_torque(axes: Array, dipole: Array, field_B: Vector3) -> Vector3:
    """Torque (Nm, body axes) of k rods along `axes` (3, k) with dipoles (k,), A m^2, in a field, T."""
    return np.cross(axes @ dipole, field_B)


def torque_map(axes: Array, field_B: Vector3) -> Array:
    """d torque / d dipole, Nm per A m^2, shape (3, k)."""
    return np.cross(axes.T, field_B).T


def capability(axes: Array, dipole_max: Array, field_B: Vector3, direction: Vector3) -> float:
    """The largest torque (Nm) along a unit direction that the rods can give."""
    return float(np.abs(direction @ torque_map(axes, field_B)) @ dipole_max)


def allocate(
    axes: Array,
    dipole_max: Array,
    field_B: Vector3,
    torque: Vector3,
    first: Vector3 | None = None,
) -> Array:
    """Dipoles (k,), A m^2, within their limits, for a torque (Nm, body axes) wanted; its component
    along the unit direction `first`, if there is one, before all else."""
    size = float(np.linalg.norm(field_B) * np.max(dipole_max, initial=0.0))
    if size < NO_FIELD * np.max(dipole_max, initial=0.0) or size == 0.0:
        return np.zeros(len(dipole_max))
    by_share = torque_map(axes, field_B) * dipole_max / size
    rows, wanted = [by_share], [torque / size]
    if first is not None:
        most = capability(axes, dipole_max, field_B, first)
        along = float(np.clip(first @ torque, -most, most))
        row = first @ by_share
        weight = PRIORITY / max(float(np.linalg.norm(row)), LEAST_PART)
        rows.append(weight * row[None, :])
        wanted.append(np.array([weight * along / size]))
    rows.append(EFFORT * np.eye(len(dipole_max)))
    wanted.append(np.zeros(len(dipole_max)))
    solution = lsq_linear(np.vstack(rows), np.concatenate(wanted), (-1.0, 1.0), method="bvls")
    shares: Array = np.clip(solution.x, -1.0, 1.0)
    return shares * dipole_max
