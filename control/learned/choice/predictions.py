"""What plans can be made with, and how each prediction has done over the period now ending."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...ground.arrays import Array, Quaternion, Vector3, WheelVector
from ...ground.attitude import turned
from ...ground.spacecraft import Spacecraft
from ...interface.measurement import Measurement
from ...model.appendage import AppendageNetwork
from ...model.momentum import MomentumModel, spin_momentum
from ..belief.friction import Friction, ramped_impulse
from ..belief.identify import Knowledge
from ..course.arc import LENGTHS, Arcs, build_arcs, fly_arc
from ..course.course import Situation
from .choice import Prediction, Trial, judge

Situations = Mapping[Prediction, Situation]
"""Where the craft is, as each prediction sees it."""


@dataclass(frozen=True)
class Locked:
    """What is known of the craft beside its loose parts, for a network that predicts those."""

    trained: Knowledge
    """What earlier flights have taught, at the first sample."""
    knowledge: Knowledge
    loose: Vector3
    """Momentum of what is loose one period ago, Nms."""


@dataclass(frozen=True)
class Learnt:
    """All that was learned up to a control instant."""

    nominal: Knowledge
    """What was known at first."""
    knowledge: Knowledge
    """Of the craft as a rigid body; what is loose is noise."""
    friction: Friction
    before: WheelVector
    """Motor torque one period before the period now ending, Nm."""
    locked: Locked | None = None


@dataclass(frozen=True, eq=False)
class Predictor:
    """The predictions at hand for a spacecraft: `build_predictor` makes it."""

    spacecraft: Spacecraft
    target: Quaternion
    period: float
    torque_max: WheelVector
    """Torque limit, or its stand-in where there is none, Nm."""
    rigid: Arcs
    loose: Arcs | None
    """With a network for what is loose, where there is one."""

    def situations(self, measurement: Measurement, learnt: Learnt) -> Situations:
        """Where the craft is, as each prediction sees it.

        Without a network the attitude is taken as it will be once what swings has come to rest.
        """
        craft, speed, known = self.spacecraft, measurement.wheel_speed, learnt.knowledge
        p = spin_momentum(craft, measurement.omega, speed)
        kept = measurement.torque - learnt.friction.torque(speed)
        limit = self.torque_max - learnt.friction.reserve(speed)
        limit = np.maximum(limit, 0.1 * self.torque_max)
        first = learnt.nominal
        believed = MomentumModel(craft, first.J, first.h_N)
        learned = MomentumModel(craft, known.J, known.h_N)
        x0 = np.concatenate([measurement.q, p, kept])
        calm = np.concatenate([turned(measurement.q, -known.sway), p, kept])
        found = {
            Prediction.NOMINAL: Situation(self.rigid, believed, first, x0, limit),
            Prediction.LEARNED: Situation(self.rigid, learned, known, calm, limit),
        }
        if self.loose is not None and learnt.locked is not None:
            known = learnt.locked.knowledge
            learned = MomentumModel(craft, known.J, known.h_N)
            x0 = np.concatenate([x0, known.loose, learnt.locked.loose, learnt.before])
            found[Prediction.NETWORK] = Situation(self.loose, learned, known, x0, limit)
        return found

    def judged(self, trial: Trial, then: Situations, plan: Array, now: Situations) -> Trial:
        """The trial after a period that began at `then` with a plan of shape (K, m)."""
        if not then or len(plan) == 0:
            return trial
        ends = {
            name: (
                self._end(before, self._flown(before, now[name], plan)),
                self._end(replace(now[name], arcs=before.arcs, model=before.model), plan[1:]),
            )
            for name, before in then.items()
        }
        return judge(trial, ends)

    def _flown(self, then: Situation, now: Situation, plan: Array) -> Array:
        """The plan with the torque that the rotors in fact kept over its first period: what
        friction took is no fault of a prediction."""
        m = self.spacecraft.wheels
        previous, rate = then.x0[4 + m : 4 + 2 * m], self.spacecraft.torque_rate_max
        meant = ramped_impulse(plan[0], previous, rate, self.period)
        return np.vstack([plan[:1] + (now.p - then.p - meant) / self.period, plan[1:]])

    def _end(self, here: Situation, plan: Array) -> Array:
        """Where a plan ends: attitude from the target, and momentum left, in rad and rad/s."""
        if len(plan) == 0:
            plan = np.zeros((1, self.spacecraft.wheels))
        plan = plan[: max(LENGTHS)]
        end, _, _ = fly_arc(here.arcs, here.model, here.x0, plan, self.period, self.target)
        return end[: 3 + self.spacecraft.actuation_rank]


def build_predictor(
    spacecraft: Spacecraft,
    target: Quaternion,
    period: float,
    torque_max: WheelVector,
    network: AppendageNetwork | None,
) -> Predictor:
    """The predictions for a spacecraft, with a network where one was trained."""
    loose = None if network is None else build_arcs(spacecraft, network)
    return Predictor(spacecraft, target, period, torque_max, build_arcs(spacecraft), loose)
