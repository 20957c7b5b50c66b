"""The learned controller: identify in flight, plan the whole manoeuvre with what is known.

Every period it takes in the new samples (`identify`, `friction`) and re-solves the rest of its
course (`course`) with the model as it is known now. Learned knowledge acts inside the prediction,
as a function of predicted attitude and wheels, where a torque added on the wheels could not cancel
the tilt of the unactuated axis.

Three safeguards: numbers that do not explain new samples are learned afresh (`trust`); the value of
the plan decides, period by period, between the nominal model, the learned one and that with a
network for what is loose (`choice`); and when no course is found, the baseline NMPC plans the
period.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..ground.arrays import Matrix3, Quaternion, WheelVector
from ..ground.attitude import rotation_matrix
from ..ground.errors import SettingsError
from ..ground.spacecraft import Spacecraft
from ..interface.blind import BlindStatus, no_torque
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from ..model.appendage import AppendageNetwork
from ..model.momentum import spin_momentum
from ..nmpc.planner import Nmpc, NmpcSettings, build_nmpc, torque_scale
from .belief.friction import Friction, learn_friction, no_friction, ramped_impulse
from .belief.identify import TRAINED_PRIOR, begin
from .belief.samples import Samples, samples_of
from .belief.trust import take_in
from .choice.choice import Prediction, Trial
from .choice.predictions import Learnt, Locked, Predictor, Situations, build_predictor
from .course.course import Course, Navigator, Situation
from .course.drift import phase_error
from .course.free_time import build_free_time
from .settings import LearnedSettings


@dataclass(frozen=True)
class LearnedMemory:
    """What one plan hands to the next."""

    learnt: Learnt
    course: Course
    trial: Trial
    """How the predictions have done."""
    then: Situations = field(default_factory=dict)
    """Where the craft was when the course was plotted, as each prediction saw it."""
    baseline: Any = None
    """The baseline planner's memory, while it flies."""


@dataclass(frozen=True, eq=False)
class Learned:
    """A spacecraft's planner: `build_learned` makes it, `plan` asks it."""

    spacecraft: Spacecraft
    settings: LearnedSettings
    period: float
    navigator: Navigator
    predictor: Predictor
    fallback: NmpcSettings
    """Settings of the planner for periods in which no course is found."""
    trained: Matrix3 | None = None
    """Inertia that earlier flights have taught, kg m^2."""

    @cached_property
    def baseline(self) -> Nmpc:
        """That planner, built when first needed."""
        return build_nmpc(self.spacecraft, self.fallback, self.navigator.target)

    def plan(
        self, measurement: Measurement, memory: LearnedMemory | None
    ) -> tuple[Plan, LearnedMemory | None]:
        """The command for the coming period."""
        memory = self._learn(measurement, memory)
        now = self.predictor.situations(measurement, memory.learnt)
        trial = self._judged(memory, now)
        here = now[trial.chosen]
        course = self.navigator.advance(memory.course, here)
        if course is None:
            return self._fall_back(measurement, memory)
        command = self._command(course.torque[0], measurement.wheel_speed, memory.learnt.friction)
        signals = self._signals(here, course, trial)
        plan = Plan(command, course.status, evidence=course, signals=signals)
        learnt = replace(memory.learnt, before=measurement.torque)
        return plan, LearnedMemory(learnt, course, trial, now)

    def fly_on(
        self, torque: WheelVector, memory: LearnedMemory | None
    ) -> tuple[Plan, LearnedMemory | None]:
        """The rest of the course, or of the baseline's plan, without a measurement; then no torque.
        Nothing is learned."""
        if memory is None:
            return no_torque(self.spacecraft.wheels), None
        memory = replace(memory, learnt=replace(memory.learnt, before=torque), then={})
        left = memory.course.torque[1:]
        memory = replace(memory, course=replace(memory.course, torque=left))
        if len(left) == 0:
            plan, state = self.baseline.fly_on(torque, memory.baseline)
            return plan, replace(memory, baseline=state)
        limit = self.spacecraft.torque_max
        return Plan(np.clip(left[0], -limit, limit), BlindStatus.FLOWN_ON), memory

    def _judged(self, memory: LearnedMemory, now: Situations) -> Trial:
        """How the predictions have done, and the one to plan with."""
        trial = self.predictor.judged(memory.trial, memory.then, memory.course.torque, now)
        fixed = self.settings.prediction
        return trial if fixed == "chosen" else replace(trial, chosen=Prediction[fixed.upper()])

    def _learn(self, measurement: Measurement, memory: LearnedMemory | None) -> LearnedMemory:
        """Memory with the newest samples taken in."""
        craft, history = self.spacecraft, measurement.history
        samples = samples_of(measurement.q, history.t, history.omega, history.wheel_speed, craft)
        if memory is None:
            course = self.navigator.depart(craft.wheels)
            learnt = self._begin(samples, np.zeros(craft.wheels))
            memory = LearnedMemory(learnt, course, Trial(Prediction.LEARNED))
        learnt = memory.learnt
        if learnt.knowledge.t == learnt.nominal.t:  # one sample so far: there may be more now
            learnt = self._begin(samples, learnt.before)
        noise = self.settings.rate_noise
        learnt = replace(
            learnt,
            knowledge=take_in(learnt.nominal, learnt.knowledge, samples, noise),
            friction=self._friction(measurement, learnt),
            locked=None if learnt.locked is None else _locked(learnt.locked, samples, noise),
        )
        return replace(memory, learnt=learnt)

    def _begin(self, samples: Samples, before: WheelVector) -> Learnt:
        """What is known at the first sample: the nominal model, and what earlier flights taught."""
        craft, noise = self.spacecraft, self.settings.rate_noise
        nominal, locked = begin(craft, samples, noise), None
        if self.trained is not None:
            trained = begin(replace(craft, J=self.trained), samples, noise, TRAINED_PRIOR)
            locked = Locked(trained, trained, np.zeros(3))
        return Learnt(nominal, nominal, no_friction(craft.wheels), before, locked)

    def _friction(self, measurement: Measurement, learnt: Learnt) -> Friction:
        """Friction after the period now ending: what the motors gave and the rotors didn't keep."""
        craft, history = self.spacecraft, measurement.history
        span = float(history.t[-1] - history.t[0])
        if abs(span - self.period) > 1e-6:
            return learnt.friction
        now, before = measurement.torque, learnt.before
        gave = ramped_impulse(now, before, craft.torque_rate_max, self.period)
        momentum = spin_momentum(craft, history.omega, history.wheel_speed)
        lost = (gave - (momentum[-1] - momentum[0])) / self.period
        ramp = np.abs(now - before)
        return learn_friction(learnt.friction, lost, history.wheel_speed, ramp, craft.speed_max)

    def _command(self, kept: WheelVector, speed: WheelVector, friction: Friction) -> WheelVector:
        """Motor torque for what the rotors are to keep: friction at mid-period added."""
        halfway = speed + 0.5 * self.period * kept / self.spacecraft.Js
        limit = self.spacecraft.torque_max
        return np.clip(kept + friction.breakaway(halfway, kept), -limit, limit)

    def _signals(self, here: Situation, course: Course, trial: Trial) -> dict[str, float]:
        """Curves for the recording."""
        signals = {
            "time_to_go_s": len(course.torque) * self.period,
            "arrival_miss_rad": np.nan if course.steering is None else course.steering.miss,
            "model_restarts": float(here.knowledge.restarts),
            "prediction": float(list(Prediction).index(trial.chosen)),
        }
        for prediction, rise in trial.rise.items():
            signals[f"value_rise_{prediction.name.lower()}_deg"] = np.rad2deg(rise)
        n = self.spacecraft.unactuated
        if n is not None:
            along = n @ rotation_matrix(here.q).T @ here.model.h_N
            signals |= {
                "stuck_momentum_Nms": float(along),
                "phi_n_deg": np.rad2deg(phase_error(here.model, here.q, self.navigator.target)),
                "landing_bias_deg": np.rad2deg(course.bias),
            }
        return signals

    def _fall_back(
        self, measurement: Measurement, memory: LearnedMemory
    ) -> tuple[Plan, LearnedMemory]:
        """The baseline's plan; the course is sought anew next time."""
        plan, state = self.baseline.plan(measurement, memory.baseline)
        course = self.navigator.depart(self.spacecraft.wheels)
        course = replace(course, searches=memory.course.searches + 1)
        learnt = replace(memory.learnt, before=measurement.torque)
        return plan, replace(memory, learnt=learnt, course=course, then={}, baseline=state)


def build_learned(
    spacecraft: Spacecraft,
    settings: LearnedSettings,
    target: Quaternion,
    baseline: NmpcSettings | None = None,
    network: AppendageNetwork | None = None,
) -> Learned:
    """The planner of a spacecraft whose inertia is believed to be about `spacecraft.J`.

    `baseline` gives the control period and the planner to fall back on; `network` predicts what is
    loose. Raises `SettingsError` if the settings ask for a network and there is none.
    """
    if settings.prediction == "network" and network is None:
        raise SettingsError(
            f"--learned.prediction network needs a network, and '{spacecraft.name}' has none here: "
            "train one (python -m learning.train_appendage) and give it as --learned.network"
        )
    baseline = baseline or NmpcSettings()
    target = np.asarray(target, float)
    period, torque_max = baseline.period, torque_scale(spacecraft, baseline)
    navigator = Navigator(settings, target, period, build_free_time(spacecraft))
    predictor = build_predictor(spacecraft, target, period, torque_max, network)
    trained = None if network is None else network.J
    return Learned(spacecraft, settings, period, navigator, predictor, baseline, trained)


def _locked(locked: Locked, samples: Samples, noise: float) -> Locked:
    """The same after new samples."""
    after = take_in(locked.trained, locked.knowledge, samples, noise)
    return replace(locked, knowledge=after, loose=locked.knowledge.loose)
