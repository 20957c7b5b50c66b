"""The learned controller: identify in flight, plan the whole manoeuvre with what is known.

Every period it takes in the new samples (`identify`, `friction`) and re-solves the rest of its
course (`course`) with the model as it is known now. Learned knowledge acts inside the prediction,
as a function of predicted attitude and wheels, where a torque added on the wheels could not cancel
the tilt of the unactuated axis.

Two safeguards: a learned model that does not explain new samples is dropped and learning starts
afresh (`trust`); and when no course is found, the baseline NMPC plans the period.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from control.learned.appendage import AppendageNetwork
from control.learned.arc import LENGTHS, Arcs, build_arcs, fly_arc
from control.learned.choice import Prediction, Trial, judge
from control.learned.course import Course, Navigator, Situation
from control.learned.drift import phase_error
from control.learned.free_time import build_free_time
from control.learned.friction import Friction, learn_friction, no_friction, ramped_impulse
from control.learned.identify import TRAINED_PRIOR, Knowledge, Samples, begin, samples_of
from control.learned.momentum import MomentumModel, spin_momentum
from control.learned.settings import LearnedSettings
from control.learned.trust import take_in
from control.measurement import Measurement
from control.nmpc import Nmpc, NmpcSettings, Plan, build_nmpc, torque_scale
from control.solver.solution import Kkt, Solution, SolverStatus
from simsat.arrays import Array, Quaternion, Vector3, WheelVector
from simsat.attitude import rotation_matrix, turned
from simsat.errors import SettingsError
from simsat.spacecraft import Spacecraft


@dataclass(frozen=True)
class LearnedMemory:
    """What one plan hands to the next."""

    start: Knowledge
    """What was known at the first plan."""
    knowledge: Knowledge
    friction: Friction
    course: Course
    before: WheelVector | None
    """Motor torque when the period now ending began, Nm; None before the first plan."""
    loose: Vector3
    """Momentum of what is loose when it began, Nms."""
    trial: Trial
    """How the predictions have done."""
    models: Mapping[Prediction, MomentumModel] = field(default_factory=dict)
    """What each predicted with, then."""
    baseline: Any = None
    """The baseline planner's memory, while it flies."""


@dataclass(frozen=True, eq=False)
class Learned:
    """A spacecraft's planner: `build_learned` makes it, `plan` asks it."""

    spacecraft: Spacecraft
    settings: LearnedSettings
    period: float
    torque_max: WheelVector
    """Torque limit, or its stand-in where there is none, Nm."""
    navigator: Navigator
    arcs: Arcs
    """Of the rigid craft."""
    fallback: NmpcSettings
    """Settings of the planner for periods in which no course is found."""
    network: AppendageNetwork | None = None
    """Predicts what is loose, where one was learned."""
    network_arcs: Arcs | None = None

    @cached_property
    def baseline(self) -> Nmpc:
        """That planner, built when first needed."""
        return build_nmpc(self.spacecraft, self.fallback, self.navigator.target)

    def plan(
        self, measurement: Measurement, memory: LearnedMemory | None
    ) -> tuple[Plan, LearnedMemory | None]:
        """The command for the coming period."""
        if not _finite(measurement):
            return self._blind(measurement, memory)
        memory = self._learn(measurement, memory)
        situations = self._situations(measurement, memory)
        trial = self._judged(memory, situations)
        here = situations[trial.chosen]
        course = self.navigator.advance(memory.course, here)
        if course is None:
            return self._fall_back(measurement, memory)
        expected = {name: self._end(one, course.torque) for name, one in situations.items()}
        memory = replace(
            memory,
            course=course,
            before=measurement.torque,
            loose=memory.knowledge.loose,
            trial=replace(trial, expected=expected),
            models={name: one.model for name, one in situations.items()},
            baseline=None,
        )
        command = self._command(course.torque[0], measurement.wheel_speed, memory.friction)
        plan = Plan(
            command, course.status, _solution(course), None, self._signals(here, course, memory)
        )
        return plan, memory

    def _learn(self, measurement: Measurement, memory: LearnedMemory | None) -> LearnedMemory:
        """Memory with the newest samples taken in."""
        craft, history = self.spacecraft, measurement.history
        samples = samples_of(measurement.q, history.t, history.omega, history.wheel_speed, craft)
        noise = self.settings.rate_noise
        if memory is None:
            course = self.navigator.depart(craft.wheels)
            friction, trial = no_friction(craft.wheels), Trial(Prediction.LEARNED)
            start, known = self._begin(samples)
            memory = LearnedMemory(start, known, friction, course, None, np.zeros(3), trial)
        elif memory.knowledge.t == memory.start.t:  # one sample so far: now there are more
            start, known = self._begin(samples)
            memory = replace(memory, start=start, knowledge=known)
        if not self.settings.learn:
            return memory
        knowledge = take_in(memory.start, memory.knowledge, samples, noise)
        return replace(memory, knowledge=knowledge, friction=self._friction(measurement, memory))

    def _begin(self, samples: Samples) -> tuple[Knowledge, Knowledge]:
        """The nominal model at the first sample, and what earlier flights have taught."""
        craft, noise = self.spacecraft, self.settings.rate_noise
        start = begin(craft, samples, noise)
        if self.network is None or not self.settings.learn:
            return start, start
        trained = replace(craft, J=self.network.J)
        return start, begin(trained, samples, noise, TRAINED_PRIOR)

    def _friction(self, measurement: Measurement, memory: LearnedMemory) -> Friction:
        """Friction after the period now ending: what the motors gave and the rotors didn't keep."""
        craft, history = self.spacecraft, measurement.history
        span = float(history.t[-1] - history.t[0])
        if memory.before is None or abs(span - self.period) > 1e-6:
            return memory.friction
        now, before = measurement.torque, memory.before
        gave = ramped_impulse(now, before, craft.torque_rate_max, self.period)
        momentum = spin_momentum(craft, history.omega, history.wheel_speed)
        lost = (gave - (momentum[-1] - momentum[0])) / self.period
        ramp = np.abs(now - before)
        return learn_friction(memory.friction, lost, history.wheel_speed, ramp, craft.speed_max)

    def _situations(
        self, measurement: Measurement, memory: LearnedMemory
    ) -> dict[Prediction, Situation]:
        """Where the craft is, as each prediction sees it."""
        craft, speed, known = self.spacecraft, measurement.wheel_speed, memory.knowledge
        p = spin_momentum(craft, measurement.omega, speed)
        kept = measurement.torque - memory.friction.torque(speed)
        reserve = memory.friction.reserve(speed)
        limit = np.maximum(self.torque_max - reserve, 0.1 * self.torque_max)
        believed = MomentumModel(craft, memory.start.J, memory.start.h_N)
        learned = MomentumModel(craft, known.J, known.h_N)
        x0 = np.concatenate([measurement.q, p, kept])
        calm = np.concatenate([turned(measurement.q, -known.sway), p, kept])
        found = {
            Prediction.NOMINAL: Situation(self.arcs, believed, memory.start, x0, limit),
            Prediction.LEARNED: Situation(self.arcs, learned, known, calm, limit),
        }
        if self.network_arcs is not None:
            before = np.zeros_like(kept) if memory.before is None else memory.before
            x0 = np.concatenate([x0, known.loose, memory.loose, before])
            arcs = self.network_arcs
            found[Prediction.NETWORK] = Situation(arcs, learned, known, x0, limit)
        return found

    def _judged(self, memory: LearnedMemory, situations: Mapping[Prediction, Situation]) -> Trial:
        """Each prediction of a period ago held against where the craft is now."""
        rest = memory.course.torque[1:]
        ends = {
            name: self._end(replace(situations[name], model=model), rest)
            for name, model in memory.models.items()
        }
        trial = judge(memory.trial, ends)
        fixed = self.settings.prediction
        return trial if fixed == "chosen" else replace(trial, chosen=Prediction[fixed.upper()])

    def _end(self, here: Situation, torque: Array) -> Array:
        """Where a plan ends, by a prediction: attitude from the target and momentum left."""
        torque = torque[: max(LENGTHS)]
        target = self.navigator.target
        if len(torque) == 0:
            torque = np.zeros((1, self.spacecraft.wheels))
        end, _, _ = fly_arc(here.arcs, here.model, here.x0, torque, self.period, target)
        return end[: 3 + self.spacecraft.actuation_rank]

    def _command(self, kept: WheelVector, speed: WheelVector, friction: Friction) -> WheelVector:
        """Motor torque for what the rotors are to keep: friction at mid-period added."""
        halfway = speed + 0.5 * self.period * kept / self.spacecraft.Js
        limit = self.spacecraft.torque_max
        return np.clip(kept + friction.breakaway(halfway, kept), -limit, limit)

    def _signals(self, here: Situation, course: Course, memory: LearnedMemory) -> dict[str, float]:
        """Curves for the recording."""
        signals = {
            "time_to_go_s": len(course.torque) * self.period,
            "arrival_miss_rad": np.nan if course.steering is None else course.steering.miss,
            "model_restarts": float(memory.knowledge.restarts),
        }
        ranks = list(Prediction)
        signals["prediction"] = float(ranks.index(memory.trial.chosen))
        for prediction, rise in memory.trial.rise.items():
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

    def _blind(
        self, measurement: Measurement, memory: LearnedMemory | None
    ) -> tuple[Plan, LearnedMemory | None]:
        """The baseline's answer to a measurement that is no number; nothing is learned from it."""
        if memory is None:
            return self.baseline.plan(measurement, None)[0], None
        return self._fall_back(measurement, memory)

    def _fall_back(
        self, measurement: Measurement, memory: LearnedMemory
    ) -> tuple[Plan, LearnedMemory]:
        """The baseline's plan; the course is sought anew next time."""
        plan, state = self.baseline.plan(measurement, memory.baseline)
        course = self.navigator.depart(self.spacecraft.wheels)
        course = replace(course, searches=memory.course.searches + 1)
        memory = replace(memory, course=course, before=measurement.torque, models={})
        return plan, replace(memory, loose=memory.knowledge.loose, baseline=state)


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
    navigator = Navigator(settings, target, baseline.period, build_free_time(spacecraft))
    return Learned(
        spacecraft,
        settings,
        baseline.period,
        torque_scale(spacecraft, baseline),
        navigator,
        build_arcs(spacecraft),
        baseline,
        network,
        None if network is None else build_arcs(spacecraft, network),
    )


def _finite(measurement: Measurement) -> bool:
    history = measurement.history
    numbers = (measurement.q, measurement.omega, measurement.wheel_speed, measurement.torque)
    return all(np.all(np.isfinite(x)) for x in (*numbers, history.omega, history.wheel_speed))


def _solution(course: Course) -> Solution:
    """The course in the form in which every planner shows its plan: states (q, p, u_prev)."""
    steering = course.steering
    if steering is None:
        empty = Kkt(np.nan, np.nan, np.nan)
        x = np.zeros((0, 0))
        return Solution(course.torque, x, np.nan, empty, 0, 0, SolverStatus.ITERATION_LIMIT)
    kkt = Kkt(np.nan, steering.miss, np.nan)
    status, count = SolverStatus.SOLVED, steering.iterations
    return Solution(steering.torque, steering.x, len(steering.torque), kkt, count, count, status)
