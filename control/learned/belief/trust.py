"""Whether what was learned still explains what is measured, and what to do if not.

The model predicts the momentum balance of samples it has not seen, and its covariance says how well
it should. If it is further off than that, either its numbers are wrong or the craft is less rigid
than was thought. So learning starts afresh with more allowance for loose parts, from the nominal
model or from the numbers learned so far, whichever predicts the new samples better. A corrupted
model costs one period, and a spacecraft that is not rigid is averaged rather than followed.
"""

from dataclasses import replace

import numpy as np

from .identify import Knowledge, forecast_error, learn, momentum_noise, restart
from .samples import Samples

SURPRISE = 4.0  # times the expected error: beyond this learning starts afresh
MORE_DOUBT = 4.0  # factor on the allowance for loose parts, at each fresh start
CALM = 0.5  # times the expected error: below this less of it is allowed for
SOON, LATE = 0.3, 0.98  # factor per calm period: before the first fresh start, and after one
INERTIA_RANGE = (0.3, 3.0)  # believable principal inertias, of the nominal extremes


def take_in(
    start: Knowledge, knowledge: Knowledge, samples: Samples, rate_noise: float
) -> Knowledge:
    """Knowledge after new samples: of the model so far if it can be trusted, else begun afresh.

    `start` is what was known at first: the nominal model.
    """
    before = trusted(start, knowledge, samples, rate_noise)
    after = learn(before, samples, rate_noise)
    if believable(start, after):
        return after
    return restart(start, samples, MORE_DOUBT * before.doubt, before.restarts + 1)


def trusted(
    start: Knowledge, knowledge: Knowledge, samples: Samples, rate_noise: float
) -> Knowledge:
    """The knowledge to go on with, before the samples are taken in."""
    wonder = surprise(knowledge, samples, rate_noise) if believable(start, knowledge) else np.inf
    if wonder < SURPRISE:
        less = 1.0 if wonder > CALM else SOON if knowledge.restarts == 0 else LATE
        return replace(knowledge, doubt=less * knowledge.doubt)
    doubt = MORE_DOUBT * max(knowledge.doubt, rate_noise)
    again = restart(start, samples, doubt, knowledge.restarts + 1)
    if believable(start, knowledge) and miss(knowledge, samples) < miss(again, samples):
        return replace(again, mean=knowledge.mean, sway=knowledge.sway)
    return again


def surprise(knowledge: Knowledge, samples: Samples, rate_noise: float) -> float:
    """Error of the predicted momentum balance over the error that was to be expected."""
    noise = momentum_noise(knowledge.J, samples, rate_noise)
    error, variance = forecast_error(knowledge, samples, noise)
    return float(np.sqrt(np.mean(error**2) / np.mean(variance)))


def miss(knowledge: Knowledge, samples: Samples) -> float:
    """Root mean square error of the predicted momentum balance, Nms."""
    error, _ = forecast_error(knowledge, samples, 0.0)
    return float(np.sqrt(np.mean(error**2)))


def believable(start: Knowledge, knowledge: Knowledge) -> bool:
    """Whether the numbers are finite and the inertia is that of a body about as large."""
    if not np.all(np.isfinite(knowledge.mean)) or not np.all(np.isfinite(knowledge.covariance)):
        return False
    found, nominal = np.linalg.eigvalsh(knowledge.J), np.linalg.eigvalsh(start.J)
    low, high = INERTIA_RANGE
    return bool(found[0] > low * nominal[0] and found[-1] < high * nominal[-1])
