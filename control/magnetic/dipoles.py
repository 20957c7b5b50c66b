"""The law of the dipoles: what the rods are asked for in a period.

Near the reference the part of the torque plane that reaches the third axis holds it there
(`third_axis`), and what is left of the rods unloads the wheels,

    tau_unload = -(H_e - H_bias) / T_unload        H_e = J omega_e + A Js Omega,

H_e being the momentum beyond what turning with the reference takes. Beside the rods' torque and
what acts from outside, the third axis feels of a reference that turns

    -n'(omega x H) - n'J omega_ref'

so that momentum left in the wheels' plane comes back along n: 2e-3 Nms at the rate of a low orbit
are as much as a small craft's rods can give. On the way to the reference the
rods take away n_ref'H_e, with which the craft could not rest there; that too comes before
unloading. Craft whose wheels push all axes are unloaded only.
"""

from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Matrix3, RodVector, Vector3
from ..ground.attitude import error_quaternion, rotation_matrix
from ..ground.spacecraft import Spacecraft
from ..interface.belief import Belief
from ..interface.measurement import Measurement
from ..reference.reference import Reference, mean_acceleration
from .allocation import allocate, capability
from .settings import RodSettings
from .third_axis import Observer, ThirdAxis, expected, observed, wanted_torque


@dataclass(frozen=True)
class DipoleState:
    """What one period hands to the next."""

    observer: Observer | None = None
    """What is known about the third axis, while it is held."""


@dataclass(frozen=True)
class Situation:
    """The craft against its reference, body axes."""

    J: Matrix3
    """Inertia as it is believed, kg m^2."""
    phi: Vector3
    """Attitude error, rad."""
    rate: Vector3
    """Rate relative to the reference, rad/s."""
    excess: Vector3
    """H_e, Nms."""
    n_ref: Vector3 | None
    """The reference's own n: along it no excess may be left on arrival."""
    along_n: float
    """Torque along n that is known beside the rods': from outside, and what turning takes, Nm."""


@dataclass(frozen=True, eq=False)
class DipoleLaw:
    """The law for one spacecraft."""

    spacecraft: Spacecraft
    """As it is believed to be before the flight."""
    settings: RodSettings
    period: float
    """Control period, s."""
    reference: Reference

    def dipoles(
        self, measurement: Measurement, field_B: Vector3, belief: Belief, state: DipoleState
    ) -> tuple[RodVector, DipoleState]:
        """Dipoles for the coming period, A m^2, in a field (T, body axes)."""
        rods, now = self.spacecraft.rods, self._situation(measurement, belief)
        unload = self._unload(now)
        if now.n_ref is None:
            return allocate(rods, field_B, unload), DipoleState()
        if self._near(now):
            return self._held(now, field_B, state)
        wanted = -float(now.n_ref @ now.excess) * self._frequency
        torque = with_part(unload, now.n_ref, wanted)
        return allocate(rods, field_B, torque, now.n_ref), DipoleState()

    def _situation(self, measurement: Measurement, belief: Belief) -> Situation:
        craft, R = self.spacecraft, rotation_matrix(measurement.q)
        q_ref = self.reference.attitude(measurement.t)
        omega_ref = self.reference.rate(measurement.t)
        from_ref, n = R.T @ rotation_matrix(q_ref), craft.unactuated
        rate = measurement.omega - from_ref @ omega_ref
        wheels = craft.A @ (craft.Js * measurement.wheel_speed)
        t = measurement.t
        turning = from_ref @ mean_acceleration(self.reference, t, t + self.period)
        beside = (
            R.T @ belief.external_N
            - np.cross(measurement.omega, belief.J @ measurement.omega + wheels)
            - belief.J @ turning
        )
        return Situation(
            J=belief.J,
            phi=2.0 * error_quaternion(measurement.q, q_ref)[1:],
            rate=rate,
            excess=belief.J @ rate + wheels,
            n_ref=None if n is None else from_ref @ n,
            along_n=0.0 if n is None else float(n @ beside),
        )

    def _near(self, now: Situation) -> bool:
        """Whether the reference is held, or about to be: near it, and slow."""
        near = np.deg2rad(self.settings.near_deg)
        slow = near * self._frequency
        return bool(np.linalg.norm(now.phi) <= near and np.linalg.norm(now.rate) <= slow)

    def _held(
        self, now: Situation, field_B: Vector3, state: DipoleState
    ) -> tuple[RodVector, DipoleState]:
        """The dipoles that hold the third axis, and unload with what is left."""
        rods, n = self.spacecraft.rods, self.spacecraft.unactuated
        assert n is not None
        row = now.J @ n  # n'J, J being symmetric
        inertia = float(n @ row)
        axis = ThirdAxis(float(row @ now.phi) / inertia, float(row @ now.rate) / inertia, inertia)
        observer = observed(state.observer, axis, self._frequency, self.period)
        known, most = now.along_n, capability(rods, field_B, n)
        wanted = wanted_torque(axis, self._frequency, known + observer.external, most)
        dipole = allocate(rods, field_B, with_part(self._unload(now), n, wanted), n)
        given = float(n @ rods.torque(dipole, field_B)) + known
        return dipole, DipoleState(expected(observer, inertia, given, self.period))

    def _unload(self, now: Situation) -> Vector3:
        """The torque that would unload the wheels, Nm."""
        time = self.settings.unloading_periods * self.period
        return -(now.excess - np.asarray(self.settings.bias_momentum_Nms)) / time

    @property
    def _frequency(self) -> float:
        """w0 of the hold, rad/s."""
        return 1.0 / (self.settings.response_periods * self.period)


def with_part(torque: Vector3, direction: Vector3, part: float) -> Vector3:
    """The torque with another component along a unit direction."""
    changed: Vector3 = torque + (part - direction @ torque) * direction
    return changed
