"""What the filter knows at one instant, and what it was told of the gyro beforehand.

The gyro reads (1 + E) omega + b + noise. The filter keeps attitude, bias b and gain error E, and
the covariance of the 15 errors (a, db, dE): a is the small turn in body axes from the estimate to
the truth, q_true = q (x) exp(a / 2), dE is taken row by row.
"""

from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Array, Matrix3, Quaternion, Vector3, Vectors3
from ..interface.measurement import Fix

ERRORS = 15
TURN, BIAS, GAIN = slice(0, 3), slice(3, 6), slice(6, 15)


@dataclass(frozen=True)
class GyroKnowledge:
    """The gyro as its data sheet has it."""

    tick: float
    """s between readings."""
    angle_random_walk: float
    """rad/sqrt(s)."""
    rate_random_walk: float
    """rad/s/sqrt(s)."""
    bias_deviation: float
    """Of each axis's bias at the start, rad/s, 1 sigma."""
    gain_deviation: Matrix3
    """Of each number of E, 1 sigma: scale factors on the diagonal, misalignment beside it."""


@dataclass(frozen=True)
class FilterState:
    """The estimate at t."""

    t: float
    q: Quaternion
    bias: Vector3
    """rad/s, body axes."""
    gain_error: Matrix3
    """E."""
    covariance: Array
    """Shape (15, 15): rad, rad/s, 1."""
    t_trusted: float
    """When a fix was last believed."""
    doubted: int = 0
    """Fixes since then that were not."""
    distance: float = 0.0
    """Normalised innovation squared of the newest fix, three degrees of freedom."""

    def rate(self, reading: Vectors3) -> Vectors3:
        """Body rates that gyro readings mean: (1 + E)^-1 (reading - b), rad/s."""
        inverse: Matrix3 = np.asarray(np.linalg.inv(np.eye(3) + self.gain_error))
        return (reading - self.bias) @ inverse.T

    @property
    def turn_deviation(self) -> float:
        """Of the attitude, all axes together, rad, 1 sigma."""
        return float(np.sqrt(np.trace(self.covariance[TURN, TURN])))


def first_state(fix: Fix, gyro: GyroKnowledge) -> FilterState:
    """The estimate at the first fix: no bias, a perfect gain, and what is known of their errors."""
    P = np.zeros((ERRORS, ERRORS))
    P[TURN, TURN] = fix.covariance
    P[BIAS, BIAS] = gyro.bias_deviation**2 * np.eye(3)
    P[GAIN, GAIN] = np.diag(gyro.gain_deviation.ravel() ** 2)
    nothing = np.array([0.0, 0.0, 0.0])
    return FilterState(fix.t, fix.q, nothing, np.zeros((3, 3)), P, fix.t)
