"""The prediction models at hand, and how each has done over the period now ending."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...ground.arrays import Array, Quaternion, WheelVector
from ...ground.spacecraft import Spacecraft
from ...ground.turn import turned
from ...interface.measurement import Measurement
from ...model.appendage import AppendageNetwork
from ...model.momentum import MomentumModel, spin_momentum
from ...model.ramp import ramped_impulse
from ..estimation.estimate import ModelEstimate
from ..estimation.estimates import Estimates
from .grid import Lengths, gathered, interval_lengths, seconds
from .propagation import Propagator, build_propagator
from .selection import ModelSelection, PredictionModel, reselected
from .state import PlanningState

LEAST_TORQUE = 0.1  # of the limit, left to plan with however large friction is taken to be

PlanningStates = Mapping[PredictionModel, PlanningState]
"""Where the craft is, as each prediction model sees it."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """The prediction models of a spacecraft: `build_candidates` makes it."""

    spacecraft: Spacecraft
    period: float
    torque_max: WheelVector
    """Torque limit, or its stand-in where there is none, Nm."""
    rigid: Propagator
    appendage: Propagator | None
    """With an appendage network, where there is one."""

    def states(self, measurement: Measurement, estimates: Estimates) -> PlanningStates:
        """Where the craft is, as each model sees it.

        Without a network the attitude is taken as it will be once the appendages are at rest.
        """
        initial, model = estimates.initial, estimates.model
        p = spin_momentum(self.spacecraft, measurement.omega, measurement.wheel_speed)
        acting = estimates.torque if measurement.origin is None else measurement.torque
        kept = acting - estimates.friction.torque(measurement.wheel_speed)
        limit = self._torque_left(measurement, estimates)
        x0 = np.concatenate([measurement.q, p, kept])
        calm = np.concatenate([turned(measurement.q, -model.deflection), p, kept])
        states = {
            PredictionModel.NOMINAL: self._state(self.rigid, initial, x0, limit),
            PredictionModel.LEARNED: self._state(self.rigid, model, calm, limit),
        }
        if self.appendage is not None and estimates.network is not None:
            known, c_before = estimates.network.model, estimates.network.appendage_momentum_before
            x0 = np.concatenate([x0, known.appendage_momentum, c_before, estimates.torque_before])
            states[PredictionModel.NETWORK] = self._state(self.appendage, known, x0, limit)
        return states

    def _state(
        self, propagator: Propagator, estimate: ModelEstimate, x0: Array, torque_max: WheelVector
    ) -> PlanningState:
        model = MomentumModel(self.spacecraft, estimate.J, estimate.h_N)
        return PlanningState(propagator, model, estimate, x0, torque_max)

    def _torque_left(self, measurement: Measurement, estimates: Estimates) -> WheelVector:
        """Torque limit less what friction will take, Nm."""
        limit = self.torque_max - estimates.friction.reserve(measurement.wheel_speed)
        return np.maximum(limit, LEAST_TORQUE * self.torque_max)

    def reselected(
        self,
        selection: ModelSelection,
        before: PlanningStates,
        plan: Array,
        now: PlanningStates,
        target: Quaternion,
    ) -> ModelSelection:
        """The selection after a period that began at `before` with a plan of shape (K, m) to end
        near the target."""
        if not before or len(plan) == 0:
            return selection
        ends = {}
        for name, state in before.items():
            lengths = interval_lengths(len(plan), state.propagator.even)
            flown = gathered(self._flown(state, now[name], plan), lengths)
            later = replace(now[name], propagator=state.propagator, model=state.model)
            ends[name] = (
                self._end(state, flown, lengths, target),
                self._end(later, flown[1:], lengths[1:], target),
            )
        return reselected(selection, ends, self.period)

    def _flown(self, before: PlanningState, now: PlanningState, plan: Array) -> Array:
        """The plan with the torque that the rotors in fact kept over its first period: what
        friction took is no fault of a prediction."""
        m = self.spacecraft.wheels
        previous, rate = before.x0[4 + m : 4 + 2 * m], self.spacecraft.torque_rate_max
        meant = ramped_impulse(plan[0], previous, rate, self.period)
        return np.vstack([plan[:1] + (now.p - before.p - meant) / self.period, plan[1:]])

    def _end(
        self, state: PlanningState, plan: Array, lengths: Lengths, target: Quaternion
    ) -> Array:
        """Where a plan ends: attitude from the target, and momentum left, in rad and rad/s."""
        if len(plan) == 0:
            plan, lengths = np.zeros((1, self.spacecraft.wheels)), np.array([1])
        h = seconds(lengths, self.period)
        end = state.propagator.end(state.model, state.x0, plan, h, target)
        return end[: 3 + self.spacecraft.actuation_rank]


def build_candidates(
    spacecraft: Spacecraft,
    period: float,
    torque_max: WheelVector,
    network: AppendageNetwork | None,
    backend: str = "auto",
) -> Candidates:
    """The prediction models of a spacecraft, with a network where one was trained; `backend` is
    that of `build_propagator`."""
    appendage = None if network is None else build_propagator(spacecraft, network, backend)
    rigid = build_propagator(spacecraft, backend=backend)
    return Candidates(spacecraft, period, torque_max, rigid, appendage)
