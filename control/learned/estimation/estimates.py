"""All estimates of one flight, and their update at a control instant."""

from dataclasses import dataclass, replace

import numpy as np

from ...ground.arrays import Matrix3, Vector3, WheelVector
from ...ground.spacecraft import Spacecraft
from ...interface.measurement import Measurement
from ...model.momentum import spin_momentum
from ...model.ramp import ramped_impulse, reached_torque
from .balance import SAMPLES_FOR_NOISE, gyro_noise
from .consistency import monitored_update
from .estimate import ModelEstimate
from .filters import Filter
from .friction import (
    SAMPLES_FOR_SCATTER,
    FrictionEstimate,
    friction_update,
    momentum_scatter,
    no_friction,
)
from .prior import TRAINED_PRIOR, initial_estimate
from .samples import Samples, joined, samples_of


@dataclass(frozen=True)
class NetworkEstimate:
    """The estimate that goes with an appendage network: about the inertia it was trained with,
    appendages apart."""

    initial: ModelEstimate
    """At the first sample."""
    model: ModelEstimate
    """Now."""
    appendage_momentum_before: Vector3
    """c one period ago, Nms."""


@dataclass(frozen=True)
class Estimates:
    """Everything estimated up to a control instant."""

    initial: ModelEstimate
    """At the first sample: the nominal model."""
    model: ModelEstimate
    """Of the craft as a rigid body; its appendages are noise."""
    friction: FrictionEstimate
    torque: WheelVector
    """Motor torque now, Nm: what its ramp has reached of the command."""
    torque_before: WheelVector
    """The same a period ago."""
    recent: Samples
    """The last samples, for the noise in them where a period has only a few."""
    network: NetworkEstimate | None = None


@dataclass(frozen=True)
class ModelEstimator:
    """What the estimates are made with."""

    spacecraft: Spacecraft
    """As it is believed to be."""
    rate_noise: float
    """Least gyro noise to assume, rad/s, 1 sigma."""
    period: float
    """Control period, s."""
    filtered: Filter
    trained_inertia: Matrix3 | None = None
    """Inertia that an appendage network was trained with, kg m^2."""
    outside: float = 1.0
    """Size of the torque from outside (see `ModelEstimate`)."""

    def update(self, measurement: Measurement, before: Estimates | None) -> Estimates:
        """The estimates with the newest samples; None before is the start of a flight."""
        h, craft = measurement.history, self.spacecraft
        rods, field_B = craft.rods.moment(measurement.dipole), measurement.field_B
        samples = samples_of(measurement.q, h.t, h.omega, h.wheel_speed, craft, rods, field_B)
        if before is None:
            before = self._initial(samples, np.zeros(craft.wheels))
        if before.model.t == before.initial.t:  # one sample so far: there may be more now
            before = self._initial(samples, before.torque)
        before = self.held(before, measurement.torque)
        before = replace(before, recent=joined(before.recent, samples))
        return replace(
            before,
            model=self._model(before, before, samples),
            friction=self._friction(measurement, before),
            network=self._network(before, samples),
        )

    def held(self, before: Estimates, torque: WheelVector) -> Estimates:
        """After a period in which that torque was commanded, nothing learned of it."""
        rate = self.spacecraft.torque_rate_max
        reached = reached_torque(torque, before.torque, rate, self.period)
        return replace(before, torque=reached, torque_before=before.torque)

    def _initial(self, samples: Samples, torque: WheelVector) -> Estimates:
        """At the first sample: the nominal model, and that with the trained inertia."""
        craft, noise = self.spacecraft, self.rate_noise
        initial = initial_estimate(craft, samples, noise, outside=self.outside)
        network = None
        if self.trained_inertia is not None:
            trained = replace(craft, J=self.trained_inertia)
            start = initial_estimate(trained, samples, noise, TRAINED_PRIOR, self.outside)
            network = NetworkEstimate(start, start, np.array([0.0, 0.0, 0.0]))
        friction = no_friction(craft)
        return Estimates(initial, initial, friction, torque, torque, samples, network)

    def _model(
        self, estimates: Estimates, before: Estimates | NetworkEstimate, samples: Samples
    ) -> ModelEstimate:
        noise = self.rate_noise
        if len(samples.t) < SAMPLES_FOR_NOISE:
            noise = gyro_noise(self.spacecraft.J, estimates.recent, noise)
        return monitored_update(before.initial, before.model, samples, noise, self.filtered)

    def _network(self, estimates: Estimates, samples: Samples) -> NetworkEstimate | None:
        before = estimates.network
        if before is None:
            return None
        after = self._model(estimates, before, samples)
        return NetworkEstimate(before.initial, after, before.model.appendage_momentum)

    def _friction(self, measurement: Measurement, before: Estimates) -> FrictionEstimate:
        """Friction after the period now ending: what the motors gave and the rotors didn't keep."""
        craft, history = self.spacecraft, measurement.history
        span = float(history.t[-1] - history.t[0])
        if abs(span - self.period) > 1e-6:
            return before.friction
        previous = before.torque_before
        gave = ramped_impulse(before.torque, previous, craft.torque_rate_max, self.period)
        momentum = spin_momentum(craft, history.omega, history.wheel_speed)
        lost = (gave - (momentum[-1] - momentum[0])) / self.period
        ramp = np.abs(before.torque - previous)
        enough = momentum if len(momentum) >= SAMPLES_FOR_SCATTER else before.recent.spin
        scatter, speeds = momentum_scatter(enough), history.wheel_speed
        return friction_update(before.friction, lost, speeds, ramp, scatter, self.period, craft)
