"""Estimators that fail, each in its own way, to show what a supervisor is worth.

Each takes the place of the network in `ResidualCorrector`, so that limit and switch stay as they
are. `good` is the estimator that they spoil.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from simsat.control.correction.corrector import CorrectorState, Estimator, ResidualCorrector
from simsat.control.ground.arrays import Quaternion, WheelVector
from simsat.control.ground.attitude import error_angle, from_axis_angle, multiply
from simsat.control.interface.layers import Correction
from simsat.control.interface.measurement import Measurement
from simsat.control.interface.plan import Plan
from simsat.control.model.ramp import ramped_torques
from simsat.control.model.rates import RateModel, predict_rate


@dataclass(frozen=True)
class Flipped:
    """The right size, the wrong sign."""

    good: Estimator

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """Minus the good estimate."""
        return -self.good.estimate(measurement, torque, -previous)


@dataclass(frozen=True)
class Constant:
    """Saturated for good."""

    value: float
    """Nm, on every wheel."""

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """The same for ever."""
        return np.full_like(torque, self.value)


@dataclass(frozen=True)
class Random:
    """Noise, the same at the same time of every flight."""

    limit: float
    """Nm."""
    seed: int = 0

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """Uniform in plus and minus the limit."""
        rng = np.random.default_rng((self.seed, round(1e3 * measurement.t)))
        return rng.uniform(-self.limit, self.limit, torque.shape)


@dataclass(frozen=True)
class Stuck:
    """Right until it freezes."""

    good: Estimator
    freezes_at: float
    """s."""

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """The good estimate until then, the last one afterwards."""
        if measurement.t < self.freezes_at:
            return self.good.estimate(measurement, torque, previous)
        return previous


@dataclass(frozen=True)
class Adversarial:
    """Knows the spacecraft and the target, and works against both."""

    model: RateModel
    rate_max: WheelVector
    target: Quaternion
    limit: float
    """Nm."""
    period: float

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """The corner of the limits after which the attitude error is largest a period ahead."""
        corners = itertools.product((-self.limit, self.limit), repeat=len(torque))
        candidates = [np.array(corner) for corner in corners]
        return max(candidates, key=lambda corner: self._error_after(measurement, torque + corner))

    def _error_after(self, measurement: Measurement, torque: WheelVector) -> float:
        state = measurement.omega, measurement.wheel_speed
        ramp = ramped_torques(torque, measurement.torque, self.rate_max, self.period)
        rate = predict_rate(self.model, *state, ramp, np.zeros(3), self.period)
        turn = 0.5 * self.period * (measurement.omega + rate) + 1e-15  # rad; never quite zero
        q = multiply(measurement.q, from_axis_angle(turn, float(np.linalg.norm(turn))))
        return float(error_angle(q, self.target))


@dataclass(frozen=True)
class NotFinite:
    """Answers NaN."""

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """NaN on every wheel."""
        return np.full_like(torque, np.nan)


@dataclass(frozen=True)
class LateCorrector:
    """A corrector whose answer arrives one period late."""

    inner: ResidualCorrector

    def correct(
        self,
        measurement: Measurement,
        plan: Plan,
        memory: tuple[CorrectorState, Correction] | None,
    ) -> tuple[Correction, tuple[CorrectorState, Correction]]:
        """What should have acted over the period that ends; nothing at first."""
        before = None if memory is None else memory[0]
        now, after = self.inner.correct(measurement, plan, before)
        nothing = Correction(np.zeros_like(plan.torque), np.zeros_like(plan.torque), now.active)
        return nothing if memory is None else memory[1], (after, now)
