"""External torque as a field that stands still in inertial space for some minutes.

    tau_B = e(J S_B) + (c x) R(q)' f        S_B = R' S_N R,   e_i(J S_B) = eps_ijk (S_B J)_jk

The first term is the gravity gradient (S_N = 3 mu / r^3 o o' for a nadir o; 6 numbers), the second
any force fixed in inertial space that acts beside the centre of mass, or any dipole in a field:
drag, sunlight, magnetic torque (D = sum of c f'; 9 numbers). Both are linear in their numbers.
"""

import numpy as np

from ...ground.arrays import Array, Matrix3, Quaternions
from ...ground.attitude import rotation_matrix

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # order of a symmetric matrix's 6 numbers

SYMMETRIC = np.zeros((6, 3, 3))
_CROSS = np.zeros((3, 3, 3))
for _index, (_i, _j) in enumerate(PAIRS):
    SYMMETRIC[_index, _i, _j] = SYMMETRIC[_index, _j, _i] = 1.0
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _CROSS[_i, _j, _k], _CROSS[_i, _k, _j] = 1.0, -1.0


def torque_map(q: Quaternions, J: Matrix3) -> Array:
    """d tau_N / d (S_N, D) at attitudes q, shape (..., 3, 15): it is linear."""
    R = rotation_matrix(q)
    across = R[..., None, :, :]
    S_B = np.swapaxes(across, -1, -2) @ SYMMETRIC @ across
    gradient = np.einsum("ijk,...ajk->...ia", _CROSS, S_B @ J)
    arm = np.einsum("ijk,...lk->...ijl", _CROSS, R).reshape(*R.shape[:-2], 3, 9)
    return R @ np.concatenate([gradient, arm], axis=-1)
