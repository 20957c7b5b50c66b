"""Where the filter starts: the estimate at the first sample, and after a re-initialisation.

The prior says: the nominal J to 10 %, no external torque to within that of a low orbit, no
appendage in motion.
"""

import numpy as np

from ...ground.arrays import Array, Vector3
from ...ground.attitude import rotation_matrix
from ...ground.spacecraft import Spacecraft
from .balance import SAMPLES_FOR_NOISE, measurement_noise, rate_matrix
from .estimate import APPENDAGE, FIELD, INERTIA, MOMENTUM, UNKNOWNS, ModelEstimate
from .external_torque import PAIRS, SYMMETRIC, torque_map
from .samples import Samples

INERTIA_PRIOR = 0.1  # of the mean principal inertia, 1 sigma: the shipped beliefs are 7 % off
TRAINED_PRIOR = 0.005  # likewise, of an inertia that was learned from earlier flights
RATE_PRIOR = 2e-4  # rad/s, 1 sigma: a MEMS gyro's noise (0.011 deg/s), until samples have shown it
GRADIENT_PRIOR = 3.7e-6  # 1/s^2: 3 mu / r^3 at 500 km
ARM_PRIOR = 1e-6  # Nm, each of the 9 numbers: drag at 450 km on an arm of 2 cm, or 0.03 A m^2
INITIAL_FLEXIBILITY = 3e-4  # rad/s: of c over the inertia; taken over: half of it changes nothing
DRAG_ALLOWANCE = 3e-6  # Nm: torque that may have acted unseen before a fresh start (400 km: 2.5e-6)
AT_REST = 1e-3  # rad/s: stored momentum over inertia, below which n'Jn has no visible effect


def initial_estimate(
    spacecraft: Spacecraft,
    samples: Samples,
    rate_noise: float,
    inertia_prior: float = INERTIA_PRIOR,
    outside: float = 1.0,
) -> ModelEstimate:
    """The estimate at the first sample: the nominal J, and the h_N that follows from it.

    `inertia_prior` is J's uncertainty, 1 sigma, over the mean principal inertia, and `outside` the
    size of the torque from outside (see `ModelEstimate`).

    How well h_N is known shows in the scatter of the samples, if there are enough of them, but is
    no better than `rate_noise` (rad/s, 1 sigma). Without stored momentum only the ratio of n'J to
    n'Jn shows: n'Jn is then left at its nominal value, which gyro noise would otherwise pull
    towards zero.
    """
    prior = _prior(spacecraft, samples, rate_noise, inertia_prior, outside)
    mean = np.zeros(UNKNOWNS)
    mean[INERTIA] = [spacecraft.J[pair] for pair in PAIRS]
    R = rotation_matrix(samples.q[0])
    follow = np.eye(UNKNOWNS)  # an error of J is one of h_N too
    follow[MOMENTUM, INERTIA] = R @ rate_matrix(samples.omega[0])
    mean = follow @ mean
    mean[MOMENTUM] += R @ samples.wheel_momentum[0]
    covariance = follow @ prior @ follow.T
    field_map = torque_map(samples.q[0], spacecraft.J)
    t = float(samples.t[0])
    return ModelEstimate(mean, covariance, t, field_map, INITIAL_FLEXIBILITY, outside=outside)


def reinitialised(
    initial: ModelEstimate, samples: Samples, flexibility: float, restarts: int
) -> ModelEstimate:
    """The initial estimate carried to these samples: h_N has hardly moved since."""
    covariance = initial.covariance.copy()
    moved = DRAG_ALLOWANCE * initial.outside * (float(samples.t[0]) - initial.t)
    covariance[MOMENTUM, MOMENTUM] += moved**2 * np.eye(3)
    t, field_map = float(samples.t[0]), torque_map(samples.q[0], initial.J)
    fresh = ModelEstimate(
        initial.mean, covariance, t, field_map, flexibility, restarts, outside=initial.outside
    )
    covariance[APPENDAGE, APPENDAGE] += fresh.appendage_deviation**2 * np.eye(3)
    return fresh


def _prior(
    spacecraft: Spacecraft,
    samples: Samples,
    rate_noise: float,
    inertia_prior: float,
    outside: float,
) -> Array:
    """Covariance of the unknowns, of h_N by the samples' scatter alone."""
    size = np.trace(spacecraft.J) / 3.0
    sigma = np.repeat([inertia_prior * size, GRADIENT_PRIOR, ARM_PRIOR, 0.0], (9, 6, 9, 3))
    sigma[FIELD] *= outside
    scatter = RATE_PRIOR * size
    if len(samples.t) >= SAMPLES_FOR_NOISE:
        scatter = measurement_noise(spacecraft.J, samples, rate_noise)
    sigma[MOMENTUM] = scatter
    prior = np.diag(sigma**2)
    if _at_rest(spacecraft, samples, size):
        prior = _without_own_scale(prior, spacecraft.unactuated)
    return prior


def _at_rest(spacecraft: Spacecraft, samples: Samples, size: float) -> bool:
    stored = spacecraft.J @ samples.omega[0] + samples.wheel_momentum[0]
    return bool(np.linalg.norm(stored) < AT_REST * size)


def _without_own_scale(prior: Array, n: Vector3 | None) -> Array:
    """The prior given that n'Jn is exact."""
    if n is None:
        return prior
    own = np.zeros(UNKNOWNS)
    own[INERTIA] = np.einsum("i,aij,j->a", n, SYMMETRIC, n)
    spread = prior @ own
    return prior - np.outer(spread, spread) / (own @ spread)
