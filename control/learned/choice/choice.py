"""Which prediction to plan with: the one under which the plan's value falls as it should.

The value of a plan of K periods is its time to go and, as an exact penalty, the miss at its end:

    V_b(x, plan) = K T + rho |e_b(x, plan)|,      e_b: where prediction b says that the plan ends.

A period later the same plan, less its first period, must be worth exactly T less. It is not, by
rho |e_b(x+, shifted plan) - e_b(x, plan)|, where the prediction was wrong: that rise is the error
of the prediction, weighed by what it does to the arrival. It needs no noise model, is blind to
errors that don't matter, and sees any error that does. Every prediction at hand is judged on the
plan that is flown, whichever that is, with the torque that the rotors in fact kept; the rises are
summed with a fading memory.

A simpler prediction is preferred until a richer one has shown that its value rises clearly less,
and again as soon as the richer one does worse. So a network or an identified model that is wrong
costs no more than the periods it takes to show. Source: Rawlings, Mayne and Diehl, Model Predictive
Control, 2nd ed., section 2.4 (the shifted plan, and the value as a Lyapunov function).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from ...ground.arrays import Array

FADING = 0.8  # of the summed rises is kept from one period to the next
ADOPT = 0.7  # a richer prediction is adopted when its rises are below this share of the simpler's
DROP = 1.2  # and left when they are above this share
NOTHING = 1e-4  # rad: rises below this don't tell predictions apart
WORST = np.pi  # rad: a rise that counts as much as any, or that is no number


class Prediction(Enum):
    """What a plan is made with, simplest first; the value is a sentence."""

    NOMINAL = "The nominal inertia, nothing learned."
    LEARNED = "The inertia and the external torque identified in flight."
    NETWORK = "The same, and a network for what is loose."


@dataclass(frozen=True)
class Trial:
    """How the predictions have done so far."""

    chosen: Prediction
    rise: Mapping[Prediction, float] = field(default_factory=dict)
    """Summed rises of the value over rho, rad."""


def judge(trial: Trial, ends: Mapping[Prediction, tuple[Array, Array]]) -> Trial:
    """The trial a period later; `ends` says where the plan ends, by each prediction as it was when
    the plan was made: from where the craft was then, and from where it is now."""
    rise = dict(trial.rise)
    for prediction, (before, end) in ends.items():
        moved = np.minimum(np.abs(np.nan_to_num(end - before, nan=WORST)), WORST)
        rise[prediction] = FADING * rise.get(prediction, 0.0) + min(
            float(np.linalg.norm(moved)), WORST
        )
    return Trial(choose(trial.chosen, rise), rise)


def choose(now: Prediction, rise: Mapping[Prediction, float]) -> Prediction:
    """The prediction to plan with, given the one in use and the summed rises."""
    ranks = list(Prediction)
    judged = [prediction for prediction in ranks if prediction in rise]
    if not judged:
        return now
    best, *richer = judged
    for prediction in richer:
        share = DROP if ranks.index(prediction) <= ranks.index(now) else ADOPT
        if rise[prediction] <= share * max(rise[best], NOTHING):
            best = prediction
    return best
