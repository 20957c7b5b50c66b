"""The measurement equation: the law of angular momentum, linear in the unknowns.

    J omega - R(q)' h_N + c = -A (Js * Omega) + noise        i.e.  H mean = z

No derivative of a measurement is needed, and bearing friction, being internal, drops out.
"""

import numpy as np

from ...ground.arrays import Array, Matrix3, Vectors3
from ...ground.attitude import rotation_matrix
from .appendage_process import appendage_correlation
from .estimate import APPENDAGE, INERTIA, MOMENTUM, UNKNOWNS, ModelEstimate
from .external_torque import SYMMETRIC
from .samples import Samples

SAMPLES_FOR_NOISE = 8  # four fourth differences: fewer tell nothing of the noise


def measurement_matrix(samples: Samples) -> Array:
    """H of the equation above, shape (k, 3, 27)."""
    H = np.zeros((len(samples.t), 3, UNKNOWNS))
    H[:, :, INERTIA] = rate_matrix(samples.omega)
    H[:, :, MOMENTUM] = -np.swapaxes(rotation_matrix(samples.q), -1, -2)
    H[:, :, APPENDAGE] = np.eye(3)
    return H


def rate_matrix(omega: Vectors3) -> Array:
    """J omega as a matrix times J's 6 numbers, shape (..., 3, 6)."""
    return np.einsum("aij,...j->...ia", SYMMETRIC, omega)


def measurement_noise(J: Matrix3, samples: Samples, rate_noise: float) -> float:
    """Noise of the momentum balance, Nms, 1 sigma: from its fourth differences, which are blind to
    anything smooth, a vibration too, and at least what the gyro's `rate_noise` makes of it."""
    floor = rate_noise * float(np.trace(J)) / 3.0
    if len(samples.t) < SAMPLES_FOR_NOISE:
        return floor
    rough = np.diff(samples.omega @ J + samples.wheel_momentum, n=4, axis=0)
    return max(floor, float(np.sqrt(np.mean(rough**2) / 70.0)))  # 1 + 16 + 36 + 16 + 1 variances


def gyro_noise(J: Matrix3, recent: Samples, least: float) -> float:
    """Gyro noise to assume of samples too few to show theirs, rad/s: what recent ones show."""
    return measurement_noise(J, recent, least) / (float(np.trace(J)) / 3.0)


def innovation(estimate: ModelEstimate, samples: Samples, noise: float) -> tuple[Array, Array]:
    """Innovation of samples not yet processed (here predicted less measured balance), Nms, and the
    variance expected of it; both of shape (k, 3). `noise` is that of `measurement_noise`."""
    keep = appendage_correlation(samples.t - estimate.t)[:, None]
    H = measurement_matrix(samples)
    H[:, :, APPENDAGE] *= keep[:, None]
    variance = np.einsum("kia,ab,kib->ki", H, estimate.covariance, H) + noise**2
    variance += (1.0 - keep**2) * estimate.appendage_deviation**2
    return H @ estimate.mean + samples.wheel_momentum, variance
