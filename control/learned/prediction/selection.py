"""Model selection: plan with the prediction model under which the plan's value falls as it should.

The value of a plan of K periods is its time to go and, as an exact penalty, the error at its end:

    V_b(x, plan) = K T + rho |e_b(x, plan)|,      e_b: where prediction model b says the plan ends.

A period later the same plan, less its first period, must be worth exactly T less. It is not, by
rho |e_b(x+, shifted plan) - e_b(x, plan)|, where the prediction was wrong: that rise is the error
of the prediction, weighed by what it does to the arrival. It needs no noise model, is blind to
errors that don't matter, and sees any error that does. Every model at hand is scored on the plan
that is flown, whichever that is, with the torque that the rotors in fact kept; the rises are summed
with a forgetting factor.

A simpler model is preferred until a richer one has shown that its value rises clearly less, and
again as soon as the richer one does worse. So a network or an identified model that is wrong costs
no more than the periods it takes to show. Source: Rawlings, Mayne and Diehl, Model Predictive
Control, 2nd ed., section 2.4 (the shifted plan, and the value as a Lyapunov function).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from ...ground.arrays import Array

# With these no wrong network costs anything (tests/bench/bad_appendages.py); also docs/learned.md.
FORGETTING = 0.8  # of the summed rises is kept after half a second: a memory of 2.5 s
ADOPT = 0.7  # a richer model is adopted when its rises are below this share of the simpler's
DROP = 1.2  # and left when they are above this share
NEGLIGIBLE = 1e-4  # rad: rises below this don't tell models apart
LARGEST = np.pi  # rad: a rise that counts as much as any, or that is no number


class PredictionModel(Enum):
    """What a plan is made with, simplest first; the value is a sentence."""

    NOMINAL = "The nominal inertia, nothing learned."
    LEARNED = "The inertia and the external torque identified in flight."
    NETWORK = "The same, and a network for the appendages."


@dataclass(frozen=True)
class ModelSelection:
    """The model to plan with, and how all have done so far."""

    selected: PredictionModel
    value_rise: Mapping[PredictionModel, float] = field(default_factory=dict)
    """Summed rises of the value over rho, rad."""


def reselected(
    selection: ModelSelection, ends: Mapping[PredictionModel, tuple[Array, Array]], period: float
) -> ModelSelection:
    """The selection a period (s) later; `ends` says where the plan ends, by each model as it was
    when the plan was made: from where the craft was then, and from where it is now."""
    rise, kept = dict(selection.value_rise), FORGETTING ** (period / 0.5)
    for model, (before, end) in ends.items():
        moved = np.minimum(np.abs(np.nan_to_num(end - before, nan=LARGEST)), LARGEST)
        rise[model] = kept * rise.get(model, 0.0) + min(float(np.linalg.norm(moved)), LARGEST)
    return ModelSelection(select(selection.selected, rise), rise)


def select(now: PredictionModel, rise: Mapping[PredictionModel, float]) -> PredictionModel:
    """The model to plan with, given the one in use and the summed rises."""
    ranks = list(PredictionModel)
    scored = [model for model in ranks if model in rise]
    if not scored:
        return now
    best, *richer = scored
    for model in richer:
        share = DROP if ranks.index(model) <= ranks.index(now) else ADOPT
        if rise[model] <= share * max(rise[best], NEGLIGIBLE):
            best = model
    return best
