"""The learned controller: identify in flight, plan the whole manoeuvre with what is known.

Every period it takes in the new samples (`identify`, `friction`) and re-solves the rest of its
course (`course`) with the model as it is known now. Learned knowledge acts inside the prediction,
as a function of predicted attitude and wheels, where a torque added on the wheels could not cancel
the tilt of the unactuated axis.

Two safeguards: a learned model that does not explain new samples is dropped and learning starts
afresh (`trust`); and when no course is found, the baseline NMPC plans the period.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from control.learned.arc import build_arcs
from control.learned.course import Course, Navigator, Situation
from control.learned.drift import phase_error
from control.learned.free_time import build_free_time
from control.learned.friction import Friction, learn_friction, no_friction, ramped_impulse
from control.learned.identify import Knowledge, begin, samples_of
from control.learned.momentum import MomentumModel, spin_momentum
from control.learned.settings import LearnedSettings
from control.learned.trust import take_in
from control.measurement import Measurement
from control.nmpc import Nmpc, NmpcSettings, Plan, build_nmpc, torque_scale
from control.solver.solution import Kkt, Solution, SolverStatus
from simsat.arrays import Quaternion, WheelVector
from simsat.attitude import rotation_matrix, turned
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
    fallback: NmpcSettings
    """Settings of the planner for periods in which no course is found."""

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
        here = self._situation(measurement, memory)
        course = self.navigator.advance(memory.course, here)
        if course is None:
            return self._fall_back(measurement, memory)
        command = self._command(course.torque[0], measurement.wheel_speed, memory.friction)
        plan = Plan(
            command, course.status, _solution(course), None, self._signals(here, course, memory)
        )
        return plan, replace(memory, course=course, before=measurement.torque, baseline=None)

    def _learn(self, measurement: Measurement, memory: LearnedMemory | None) -> LearnedMemory:
        """Memory with the newest samples taken in."""
        craft, history = self.spacecraft, measurement.history
        samples = samples_of(measurement.q, history.t, history.omega, history.wheel_speed, craft)
        noise = self.settings.rate_noise
        if memory is None:
            course = self.navigator.depart(craft.wheels)
            start = begin(craft, samples, noise)
            memory = LearnedMemory(start, start, no_friction(craft.wheels), course, None)
        elif memory.knowledge.t == memory.start.t:  # one sample so far: now there are more
            start = begin(craft, samples, noise)
            memory = replace(memory, start=start, knowledge=start)
        if not self.settings.learn:
            return memory
        knowledge = take_in(memory.start, memory.knowledge, samples, noise)
        return replace(memory, knowledge=knowledge, friction=self._friction(measurement, memory))

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

    def _situation(self, measurement: Measurement, memory: LearnedMemory) -> Situation:
        craft, speed, known = self.spacecraft, measurement.wheel_speed, memory.knowledge
        p = spin_momentum(craft, measurement.omega, speed)
        kept = measurement.torque - memory.friction.torque(speed)
        q = turned(measurement.q, -known.sway)
        x0 = np.concatenate([q, p, kept])
        reserve = memory.friction.reserve(speed)
        limit = np.maximum(self.torque_max - reserve, 0.1 * self.torque_max)
        return Situation(MomentumModel(craft, known.J, known.h_N), known, x0, limit)

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
        return plan, replace(memory, course=course, before=measurement.torque, baseline=state)


def build_learned(
    spacecraft: Spacecraft,
    settings: LearnedSettings,
    target: Quaternion,
    baseline: NmpcSettings | None = None,
) -> Learned:
    """The planner of a spacecraft whose inertia is believed to be about `spacecraft.J`.

    `baseline` gives the control period and the planner to fall back on.
    """
    baseline = baseline or NmpcSettings()
    target = np.asarray(target, float)
    navigator = Navigator(
        settings, target, baseline.period, build_arcs(spacecraft), build_free_time(spacecraft)
    )
    return Learned(
        spacecraft,
        settings,
        baseline.period,
        torque_scale(spacecraft, baseline),
        navigator,
        baseline,
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
