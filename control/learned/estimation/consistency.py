"""The consistency monitor: does the estimate still explain what is measured, and what if not.

The filter predicts the momentum balance of samples it has not seen, and its covariance says how
well it should. If the innovation is larger than that, either the numbers are wrong or the craft is
less rigid than was thought. So the filter is re-initialised with more allowance for flexibility,
from the nominal model or from the numbers so far, whichever predicts the new samples better. A
corrupted estimate costs one period, and a spacecraft that is not rigid is averaged rather than
followed. (Consistency tests of innovations: Bar-Shalom, Li and Kirubarajan, section 5.4.)
"""

from dataclasses import replace

import numpy as np

from .balance import innovation, measurement_noise
from .estimate import ModelEstimate
from .filters import Filter
from .prior import reinitialised
from .samples import Samples

# Taken over from the first flights of panels and propellant; half and twice: docs/learned.md.
INCONSISTENT = 4.0  # normalised innovation beyond which the filter is re-initialised
INFLATION = 4.0  # factor on the allowance for flexibility at each re-initialisation
OVERCAUTIOUS = 0.5  # normalised innovation below which the allowance shrinks
DECAY, LATE_DECAY = 0.3, 0.98  # factor in half a second: before the first restart, and after one
INERTIA_RANGE = (0.3, 3.0)  # plausible principal inertias, of the nominal extremes: beyond 3 sigma


def monitored_update(
    initial: ModelEstimate,
    estimate: ModelEstimate,
    samples: Samples,
    rate_noise: float,
    filtered: Filter,
) -> ModelEstimate:
    """The estimate after new samples: filtered on if it is consistent, else from a fresh start.

    `initial` is the estimate at the first sample: the nominal model.
    """
    before = consistent(initial, estimate, samples, rate_noise)
    after = filtered(before, samples, rate_noise)
    if plausible(initial, after):
        return after
    return reinitialised(initial, samples, INFLATION * before.flexibility, before.restarts + 1)


def consistent(
    initial: ModelEstimate, estimate: ModelEstimate, samples: Samples, rate_noise: float
) -> ModelEstimate:
    """The estimate to go on from, before the samples are processed."""
    sane = plausible(initial, estimate)
    size = normalised_innovation(estimate, samples, rate_noise) if sane else np.inf
    if size < INCONSISTENT:
        shrink = DECAY if estimate.restarts == 0 else LATE_DECAY
        factor = 1.0 if size > OVERCAUTIOUS else shrink ** float(np.ptp(samples.t) / 0.5)
        return replace(estimate, flexibility=factor * estimate.flexibility)
    flexibility = INFLATION * max(estimate.flexibility, rate_noise)
    fresh = reinitialised(initial, samples, flexibility, estimate.restarts + 1)
    if sane and innovation_rms(estimate, samples) < innovation_rms(fresh, samples):
        return replace(fresh, mean=estimate.mean, deflection=estimate.deflection)
    return fresh


def normalised_innovation(estimate: ModelEstimate, samples: Samples, rate_noise: float) -> float:
    """RMS of the innovation over the standard deviation expected of it."""
    noise = measurement_noise(estimate.J, samples, rate_noise)
    error, variance = innovation(estimate, samples, noise)
    return float(np.sqrt(np.mean(error**2) / np.mean(variance)))


def innovation_rms(estimate: ModelEstimate, samples: Samples) -> float:
    """RMS of the innovation, Nms."""
    error, _ = innovation(estimate, samples, 0.0)
    return float(np.sqrt(np.mean(error**2)))


def plausible(initial: ModelEstimate, estimate: ModelEstimate) -> bool:
    """Whether the numbers are finite and the inertia is that of a body about as large."""
    if not np.all(np.isfinite(estimate.mean)) or not np.all(np.isfinite(estimate.covariance)):
        return False
    found, nominal = np.linalg.eigvalsh(estimate.J), np.linalg.eigvalsh(initial.J)
    low, high = INERTIA_RANGE
    return bool(found[0] > low * nominal[0] and found[-1] < high * nominal[-1])
