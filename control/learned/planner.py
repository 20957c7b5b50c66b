"""The learned controller: identify in flight, plan the whole slew with what is known.

Every period it updates its estimates (`estimation`), selects a prediction model (`prediction`) and
solves the rest of its trajectory anew (`guidance`). Estimates act inside the prediction, as a
function of predicted attitude and wheels, where a torque added on the wheels could not cancel the
tilt of the unactuated axis.

Three safeguards: an estimate that doesn't explain new samples is re-initialised (`consistency`);
the value of the plan decides, period by period, between the nominal model, the identified one and
that with an appendage network (`selection`); and when no trajectory is found, the baseline NMPC
plans the period.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..ground.arrays import Quaternion, Vector3, WheelVector
from ..ground.attitude import error_angle
from ..ground.errors import SettingsError
from ..ground.spacecraft import Spacecraft
from ..interface.belief import Belief
from ..interface.blind import BlindStatus, no_torque
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from ..model.appendage import AppendageNetwork
from ..nmpc.planner import Nmpc, NmpcSettings, build_nmpc, torque_scale
from ..reference.reference import Reference
from .estimation.estimates import Estimates, ModelEstimator
from .estimation.filters import choose_filter
from .estimation.friction import FrictionEstimate
from .guidance.minimum_time import build_minimum_time
from .guidance.replan import replan, unplanned
from .guidance.task import GuidanceTask
from .guidance.trajectory import Trajectory
from .prediction.candidates import Candidates, PlanningStates, build_candidates
from .prediction.selection import ModelSelection, PredictionModel
from .settings import LearnedSettings
from .signals import signals_of


@dataclass(frozen=True)
class PlannerState:
    """What one plan hands to the next."""

    estimates: Estimates
    trajectory: Trajectory
    selection: ModelSelection
    planned_from: PlanningStates = field(default_factory=dict)
    """Where the craft was when the trajectory was planned, as each prediction model saw it."""
    baseline: Any = None
    """The baseline planner's memory, while it flies."""


@dataclass(frozen=True, eq=False)
class LearnedPlanner:
    """A spacecraft's planner: `build_learned_planner` makes it, `plan` asks it."""

    settings: LearnedSettings
    estimator: ModelEstimator
    candidates: Candidates
    task: GuidanceTask
    fallback: NmpcSettings
    """Settings of the planner for periods in which no trajectory is found."""

    @property
    def spacecraft(self) -> Spacecraft:
        """As it is believed to be before the flight."""
        return self.candidates.spacecraft

    @cached_property
    def baseline(self) -> Nmpc:
        """The planner to fall back on, built when first needed."""
        return build_nmpc(self.spacecraft, self.fallback, self.task.target)

    def plan(
        self, measurement: Measurement, memory: PlannerState | None
    ) -> tuple[Plan, PlannerState | None]:
        """The command for the coming period."""
        memory = self._updated(measurement, memory)
        estimates = memory.estimates
        states = self.candidates.states(measurement, estimates)
        task = self.task.at(measurement.t)
        selection = self._selection(memory, states, task.target)
        state, asked = states[selection.selected], task.target
        task = task.aimed(state.model)
        trajectory = replan(task, memory.trajectory, state)
        if trajectory is None:
            return self._fall_back(measurement, memory)
        torque = self._command(trajectory.torque[0], measurement.wheel_speed, estimates.friction)
        signals = signals_of(task, state, trajectory, selection)
        off = float(error_angle(task.target, asked))
        signals["rest_off_target_deg"] = np.rad2deg(off)
        belief = Belief(
            state.model.J,
            self._external_torque(measurement, estimates),
            estimates.friction.torque(measurement.wheel_speed),
        )
        plan = Plan(
            torque, trajectory.status, evidence=trajectory, signals=signals, belief=belief
        )  # fmt: skip
        return plan, PlannerState(estimates, trajectory, selection, states)

    def fly_on(
        self, torque: WheelVector, memory: PlannerState | None
    ) -> tuple[Plan, PlannerState | None]:
        """The rest of the trajectory, or of the baseline's plan, without a measurement; then no
        torque. Nothing is learned."""
        if memory is None:
            return no_torque(self.spacecraft.wheels), None
        left = memory.trajectory.torque[1:]
        memory = replace(
            memory,
            estimates=self.estimator.held(memory.estimates, torque),
            trajectory=replace(memory.trajectory, torque=left),
            planned_from={},
        )
        if len(left) == 0:
            plan, state = self.baseline.fly_on(torque, memory.baseline)
            return plan, replace(memory, baseline=state)
        limit = self.spacecraft.torque_max
        return Plan(np.clip(left[0], -limit, limit), BlindStatus.FLOWN_ON), memory

    def _updated(self, measurement: Measurement, memory: PlannerState | None) -> PlannerState:
        """The state with the newest samples in its estimates."""
        if memory is None:
            estimates = self.estimator.update(measurement.sensed, None)
            trajectory = unplanned(self.task, self.spacecraft.wheels)
            return PlannerState(estimates, trajectory, ModelSelection(PredictionModel.LEARNED))
        return replace(
            memory, estimates=self.estimator.update(measurement.sensed, memory.estimates)
        )

    def _external_torque(self, measurement: Measurement, estimates: Estimates) -> Vector3:
        """External torque to expect where the craft is, as far as it can be relied upon, Nm."""
        model = estimates.model
        return model.torque_confidence * model.external_torque(measurement.q)

    def _selection(
        self, memory: PlannerState, now: PlanningStates, target: Quaternion
    ) -> ModelSelection:
        """The prediction model to plan with: by the plan's value, unless the settings fix it."""
        before, plan = memory.planned_from, memory.trajectory.torque
        selection = self.candidates.reselected(memory.selection, before, plan, now, target)
        fixed = self.settings.prediction
        if fixed == "chosen":
            return selection
        return replace(selection, selected=PredictionModel[fixed.upper()])

    def _command(
        self, kept: WheelVector, speed: WheelVector, friction: FrictionEstimate
    ) -> WheelVector:
        """Motor torque for what the rotors are to keep: friction at mid-period added."""
        halfway = speed + 0.5 * self.task.period * kept / self.spacecraft.Js
        limit = self.spacecraft.torque_max
        return np.clip(kept + friction.breakaway(halfway, kept), -limit, limit)

    def _fall_back(
        self, measurement: Measurement, memory: PlannerState
    ) -> tuple[Plan, PlannerState]:
        """The baseline's plan; the trajectory is sought anew next time."""
        target = self.task.at(measurement.t).target
        baseline = replace(self.baseline, target=target)
        plan, state = baseline.plan(measurement, memory.baseline)
        searches = memory.trajectory.searches + 1
        return plan, replace(
            memory,
            trajectory=unplanned(self.task, self.spacecraft.wheels, searches),
            planned_from={},
            baseline=state,
        )


def build_learned_planner(
    spacecraft: Spacecraft,
    settings: LearnedSettings,
    target: Quaternion,
    baseline: NmpcSettings | None = None,
    network: AppendageNetwork | None = None,
    outside: float = 1.0,
    reference: Reference | None = None,
) -> LearnedPlanner:
    """The planner of a spacecraft whose inertia is believed to be about `spacecraft.J`.

    `outside` is the size of the torque from outside, 1 in SI and low orbit (see `ModelEstimate`);
    `baseline` gives the control period and the planner to fall back on; `network` predicts the
    appendages; `reference`, where it moves, takes the target's place. Raises `SettingsError` if the
    settings ask for a network and there is none.
    """
    if settings.prediction == "network" and network is None:
        raise SettingsError(
            f"--learned.prediction network needs a network, and '{spacecraft.name}' has none here: "
            "train one (python -m learning.train_appendage) and give it as --learned.network"
        )
    baseline = baseline or NmpcSettings()
    moving = reference if reference is not None and reference.moving else None
    target = np.asarray(target if moving is None else moving.attitude(0.0), float)
    period, torque_max = baseline.stage, torque_scale(spacecraft, baseline)
    backend = baseline.solver.backend
    trained, filtered = None if network is None else network.J, choose_filter(backend)
    return LearnedPlanner(
        settings,
        ModelEstimator(spacecraft, settings.noise, period, filtered, trained, outside),
        build_candidates(spacecraft, period, torque_max, network, backend),
        GuidanceTask(settings, target, period, build_minimum_time(spacecraft), moving),
        baseline,
    )
