"""What the network sees: the paper's 16 inputs for two wheels, 2 m + 12 for m wheels.

    previous estimate (m) | omega_k (3) | omega_{k-1} (3) | (omega_k - omega_{k-1})/dt (3)
    | u_k (m) | omega_k x J omega_k (3)

u_k is the motor torque about to be applied, J the believed inertia, k-1 the previous control
instant (dt = 0.5 s). The paper names the previous estimate, the current and previous rates and the
torques, and counts 14 features beside the estimate; this reading of them is ours. With the sample
before (20 Hz) as k-1 the network is as good on exact rates, and worse on noisy ones
(docs/network.md).
"""

import numpy as np

from ..ground.arrays import Array, Matrix3, Vectors3, WheelVectors
from ..model.rates import Tensor, cross


def feature_count(wheels: int) -> int:
    """Number of inputs for so many wheels."""
    return 2 * wheels + 12


def features(
    previous: WheelVectors,
    omega: Vectors3,
    omega_before: Vectors3,
    interval: float,
    torque: WheelVectors,
    J: Matrix3,
) -> Array:
    """The inputs in the order above, shape (..., 2 m + 12).

    `interval` is the time between the two rates, s.
    """
    acceleration = (omega - omega_before) / interval
    gyroscopic: Tensor = cross(omega, omega @ J.T)
    return np.concatenate(
        [previous, omega, omega_before, acceleration, torque, gyroscopic], axis=-1
    )
