"""Where a craft with two wheels can rest when its momentum doesn't let it rest at the target.

At rest the wheels hold the whole momentum H, so H lies in the plane of their axes: n'H = 0. With a
momentum h = n'H at the target the body has to spin about n there, at s = h / n'Jn, or to cone
around the target to undo the spin, at an angle of about

    rho = (2 s)^(2/3) (J / u_max)^(1/3)        (20 degrees for 1 deg/s and the paper's wheels)

Turned by asin(h / |H|) it can stand still instead. Only an external torque changes the choice.
"""

import numpy as np

from ..ground.arrays import Quaternion, Vector3
from ..ground.attitude import from_axis_angle, multiply, rotation_matrix
from ..ground.spacecraft import Spacecraft

FASTEST_CONING = np.deg2rad(2.0)  # rad/s of spin to undo; rho is 30 degrees there, no pointing


def nearest_rest(spacecraft: Spacecraft, target: Quaternion, H_N: Vector3) -> Quaternion | None:
    """The attitude nearest to the target in which the craft can rest with momentum H_N (inertial
    axes, Nms); None where staying around the target is better, or needs no choice."""
    n = spacecraft.unactuated
    H_T = rotation_matrix(target).T @ H_N
    if n is None or not np.linalg.norm(H_T) > 0.0:
        return None
    turn = float(np.arcsin(n @ H_T / np.linalg.norm(H_T)))
    spin = float(abs(n @ H_T) / (n @ spacecraft.J @ n))
    if spin <= FASTEST_CONING and abs(turn) >= coning_angle(spacecraft, spin):
        return None
    across = np.cross(H_T, n)
    if np.linalg.norm(across) < 1e-6 * np.linalg.norm(H_T):
        across = np.cross(spacecraft.A[:, 0], n)  # H along n: every direction is as near
    return multiply(target, from_axis_angle(across, turn))


def coning_angle(spacecraft: Spacecraft, spin: float) -> float:
    """rho of the equation above, rad, for a spin (rad/s) about the unactuated axis."""
    inertia = float(np.trace(spacecraft.J)) / 3.0
    return float((2.0 * spin) ** (2.0 / 3.0) * (inertia / np.min(spacecraft.torque_max)) ** (1 / 3))
