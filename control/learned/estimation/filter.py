"""The Kalman filter: all unknowns from gyro and wheel speeds, sample by sample.

Time update: h_N' = R(q) tau_B moves the momentum by the estimated torque and by what is known, c
decays, everything grows a little less certain. Measurement update: the momentum balance of
`balance`. The filter needs no training. At rest nothing is learned of J; one second of slew is
enough. `filter.c` does the same, step for step.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ...ground.arrays import Array, Vector3
from .appendage_process import appendage_correlation, next_deflection
from .balance import measurement_matrix, measurement_noise
from .estimate import APPENDAGE, FIELD, INERTIA, MOMENTUM, UNKNOWNS, ModelEstimate
from .external_torque import torque_map
from .samples import Samples

QUIET = 1e-2  # rad/s, a tenth of a slew's: below, what little shows of J is not rigid motion
FIELD_WALK = 3e-9  # Nm (and 1/s^2) in a second: an orbit turns the field by 4 deg a minute
MOMENTUM_WALK = 1e-9  # Nms in a second: torque that no field of this kind explains


def walk(outside: float) -> Array:
    """Variance that each unknown gains in a second, shape (27,).

    In units in which the torque from outside is `outside` times as large, an orbit is faster by the
    root of that, and a walk goes with the root of time.
    """
    momentum, field = MOMENTUM_WALK * outside**0.75, FIELD_WALK * outside**1.25
    return np.repeat([0.0, momentum**2, field**2, 0.0], (6, 3, 15, 3))


def filtered(estimate: ModelEstimate, samples: Samples, rate_noise: float) -> ModelEstimate:
    """The estimate after all samples newer than itself.

    `rate_noise` (rad/s, 1 sigma) is the least gyro noise to assume; what the samples themselves
    scatter by counts if it is more.
    """
    noise = measurement_noise(estimate.J, samples, rate_noise)
    maps = torque_map(samples.q, estimate.J)
    H = measurement_matrix(samples)
    for k in np.flatnonzero(is_new(estimate, samples)):
        ahead = _time_update(estimate, float(samples.t[k]), maps[k], samples.known_torque[k])
        quiet = bool(np.linalg.norm(samples.omega[k]) < QUIET)
        after = _measurement_update(ahead, H[k], samples.wheel_momentum[k], noise, quiet)
        estimate = replace(after, deflection=next_deflection(estimate, after))
    return estimate


def is_new(estimate: ModelEstimate, samples: Samples) -> Any:
    """Which of the samples the estimate has not seen."""
    return samples.t > estimate.t + 1e-9


def _time_update(
    estimate: ModelEstimate, t: float, map_then: Array, known_torque: Vector3
) -> ModelEstimate:
    """The estimate at time t: h_N moved by known torque and the field's, c decayed, all less
    certain."""
    dt = t - estimate.t
    move = 0.5 * dt * (estimate.torque_map + map_then)
    mean, P = estimate.mean.copy(), estimate.covariance.copy()
    mean[MOMENTUM] += move @ mean[FIELD] + dt * known_torque
    P[MOMENTUM] += move @ P[FIELD]
    P[:, MOMENTUM] += P[:, FIELD] @ move.T
    P[np.diag_indices(UNKNOWNS)] += walk(estimate.outside) * dt
    keep = float(appendage_correlation(np.asarray(dt)))
    mean[APPENDAGE] *= keep
    P[APPENDAGE] *= keep
    P[:, APPENDAGE] *= keep
    P[APPENDAGE, APPENDAGE] += (1.0 - keep**2) * estimate.appendage_deviation**2 * np.eye(3)
    return replace(estimate, mean=mean, covariance=P, t=t, torque_map=map_then)


def _measurement_update(
    estimate: ModelEstimate, H: Array, wheel_momentum: Vector3, noise: float, quiet: bool
) -> ModelEstimate:
    """The estimate after the balance H mean = -A (Js Omega) was measured."""
    P = estimate.covariance
    HP = H @ P
    gain = np.linalg.solve(HP @ H.T + noise**2 * np.eye(3), HP).T
    if quiet:
        gain[INERTIA] = 0.0
    mean = estimate.mean - gain @ (wheel_momentum + H @ estimate.mean)
    keep = np.eye(UNKNOWNS) - gain @ H
    P = keep @ P @ keep.T + noise**2 * gain @ gain.T  # Joseph: right for any gain
    return replace(estimate, mean=mean, covariance=0.5 * (P + P.T))
