"""Layer two: torque on the wheels against what the nominal model misses.

An *estimator* says which torque tau_hat on the wheel axes the nominal model misses over the coming
period. The hub feels -A u, so that u = plan + tau_hat cancels it: the spacecraft then moves as the
planner predicted. Sources: the paper, section 2 (bounds and the switch).
"""

from dataclasses import dataclass, field
from typing import Annotated, Protocol, runtime_checkable

import numpy as np

from ..ground.arrays import Matrix3, Quaternion, Vector3, WheelVector
from ..ground.attitude import error_angle
from ..ground.own import Own, own
from ..ground.settings import Positive, Settings
from ..interface.layers import Correction
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from ..model.ramp import ramped_torques
from ..model.rates import RateModel, predict_rate, residual_torque
from .features import features
from .network import Network
from .switch import SwitchSettings, switched


@dataclass(frozen=True)
class CorrectionSettings(Settings, group="correction"):
    """How much of the learned correction may act, and when."""

    limit_Nm: Annotated[Positive | None, Own("torque", 0.015)] = None
    """Largest correction of each wheel, Nm; 0.015 in the craft's own units, 30 % of its torque,
    unless given."""
    switch: SwitchSettings = field(default_factory=SwitchSettings)
    foreign_network: bool = False
    """Fly a network that was trained for another spacecraft or belief: for robustness studies."""

    @property
    def limit(self) -> float:
        """Largest correction of each wheel."""
        return own(self, "limit_Nm")


@runtime_checkable
class Estimator(Protocol):
    """Says what the nominal model misses."""

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """Residual torque on the wheel axes, Nm, if `torque` (Nm) is commanded now; `previous` is
        the estimate of one period ago."""
        ...


@dataclass(frozen=True)
class CorrectorState:
    """What one correction hands to the next."""

    estimate: WheelVector
    on: bool


@dataclass(frozen=True)
class ResidualCorrector:
    """A corrector: an estimator, the limit and the switch."""

    estimator: Estimator
    settings: CorrectionSettings
    target: Quaternion

    def correct(
        self, measurement: Measurement, plan: Plan, memory: CorrectorState | None
    ) -> tuple[Correction, CorrectorState]:
        """The torque to add to the plan's; zero, but still estimated, while switched off.

        An estimate that isn't finite is passed on as NaN, which the loop leaves out, and is
        forgotten: the next one has no estimate before it, as the first had none.
        """
        before = memory or CorrectorState(np.zeros_like(plan.torque), True)
        with np.errstate(over="ignore", invalid="ignore"):  # an overflow shows in the answer
            estimate = self.estimator.estimate(measurement, plan.torque, before.estimate)
        error = float(error_angle(measurement.q, self.target))
        on = switched(before.on, error, self.settings.switch)
        limit = self.settings.limit
        torque = np.clip(estimate, -limit, limit) if on else np.zeros_like(estimate)
        if not np.isfinite(estimate).all():
            unknown = np.full_like(plan.torque, np.nan)
            return Correction(unknown, estimate, on), CorrectorState(np.zeros_like(unknown), on)
        return Correction(torque, estimate, on), CorrectorState(estimate, on)


@dataclass(frozen=True)
class NetworkEstimator:
    """Asks a network."""

    network: Network
    J: Matrix3
    """Believed inertia, kg m^2."""

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """The network's answer; at the first instant the rate counts as constant."""
        t, rates = measurement.history.t, measurement.history.omega
        interval = float(t[-1] - t[0]) if len(t) > 1 else 1.0
        before = rates[0] if len(t) > 1 else measurement.omega
        x = features(previous, measurement.omega, before, interval, torque, self.J)
        return self.network.estimate(x)


@runtime_checkable
class Surroundings(Protocol):
    """The torque of the environment, for an oracle."""

    def torque(self, t: float, q: Quaternion) -> Vector3:
        """Nm, body axes."""
        ...


@dataclass(frozen=True)
class OracleEstimator:
    """Knows the truth: the residual itself, as far as torque on the wheel axes can express it.

    It predicts the rates with the true spacecraft, its friction and its environment, and with the
    believed model, and asks which torque on the wheels makes up for the difference.
    """

    truth: RateModel
    believed: RateModel
    rate_max: WheelVector
    """Nm/s, of the motors."""
    surroundings: Surroundings
    period: float
    """Length of a control period, s."""

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        """The residual torque; `previous` doesn't matter to who knows the truth."""
        omega, speed, period = measurement.omega, measurement.wheel_speed, self.period
        torques = ramped_torques(torque, measurement.torque, self.rate_max, period)
        external = self.surroundings.torque(measurement.t, measurement.q)
        rate = predict_rate(self.truth, omega, speed, torques, external, period)
        return residual_torque(self.believed, omega, speed, torques, rate, period)
