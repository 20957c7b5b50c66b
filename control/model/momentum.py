"""A spacecraft with wheels in momentum form: exact, with the fewest unknown numbers.

With the spin momentum of each rotor about its axis, p = Js (Omega + A' omega), and the total
angular momentum h_N, which only external torque changes,

    p' = u                                       (motor torque less bearing friction)
    omega = J_hub^-1 (R(q)' h_N - A p)           J_hub = J - A Js A'
    q' = 1/2 q (x) (0, omega)

The rate is no state: it follows from attitude and wheels. What the wheels can't give is built in:
at h_N = 0 the admissible rates fill a plane with the normal J n, and five numbers of J decide
everything. Source: the momentum theorem; Schaub and Junkins, section 4.5.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..ground.arrays import Array, Matrix3, Quaternion, Vector3, Vectors3, WheelVector, WheelVectors
from ..ground.attitude import rotation_matrix
from ..ground.spacecraft import RANK_TOLERANCE, Spacecraft


@dataclass(frozen=True)
class MomentumModel:
    """What a plan is made with: the wheels as the file has them, J and h_N as they are believed."""

    spacecraft: Spacecraft
    """Wheels and limits; its J is not used."""
    J: Matrix3
    """kg m^2, body axes, rotors included."""
    h_N: Vector3
    """Total angular momentum, inertial axes, Nms."""

    @cached_property
    def J_hub(self) -> Matrix3:
        """J - A Js A', kg m^2."""
        A = self.spacecraft.A
        return self.J - (A * self.spacecraft.Js) @ A.T

    @cached_property
    def J_hub_inverse(self) -> Matrix3:
        """Its inverse."""
        return np.asarray(np.linalg.inv(self.J_hub))

    def rate(self, q: Quaternion, p: WheelVector) -> Vector3:
        """Body rate (body axes, rad/s) that momentum conservation leaves."""
        return self.J_hub_inverse @ (rotation_matrix(q).T @ self.h_N - self.spacecraft.A @ p)

    @cached_property
    def tilt(self) -> Vector3 | None:
        """J n / (n' J n): phi_n = tilt'phi is what a small motion of the wheels can't change."""
        n = self.spacecraft.unactuated
        return None if n is None else self.J @ n / (n @ self.J @ n)


def spin_momentum(
    spacecraft: Spacecraft, omega: Vectors3, wheel_speed: WheelVectors
) -> WheelVectors:
    """p = Js (Omega + A' omega), Nms."""
    return spacecraft.Js * (wheel_speed + omega @ spacecraft.A)


def actuated_basis(spacecraft: Spacecraft) -> Array:
    """Orthonormal columns that span the wheel axes, shape (3, rank)."""
    U, size, _ = np.linalg.svd(spacecraft.A, full_matrices=False)
    basis: Array = U[:, size > RANK_TOLERANCE]
    return basis
