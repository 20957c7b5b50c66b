"""The planner of dipoles, beside the planner of wheel torques.

Every period, from the same measurement: near the reference the part of the torque plane that
reaches the third axis holds it there (`third_axis`), and what is left of the rods unloads the
wheels. On the way to it they take away the momentum along the reference's own third axis, with
which the craft could not rest there; that too comes before unloading. Craft whose wheels push all
axes are unloaded only.

    tau_unload = -(H_B - J omega_ref - H_bias) / T_unload         on the way: -n'(H_B - J omega_ref) / T
"""

from dataclasses import dataclass, field

import numpy as np

from ..ground.arrays import Array, Matrix3, Quaternion, Vector3
from ..ground.attitude import error_quaternion, rotation_matrix
from ..ground.spacecraft import Spacecraft
from ..interface.measurement import Measurement
from .allocation import allocate, capability, rod_torque
from .settings import RodSettings
from .third_axis import Observer, ThirdAxis, expected, observed, wanted_torque


@dataclass(frozen=True)
class Aim:
    """What the craft is to do at the end of the coming period."""

    q: Quaternion
    """Reference attitude, body -> inertial."""
    omega: Vector3
    """Its rate, rad/s, in its own body axes."""


@dataclass(frozen=True)
class Known:
    """What a planner of torques has learned in flight and tells that of dipoles."""

    J: Matrix3
    """Inertia, kg m^2."""
    external_N: Vector3 = field(default_factory=lambda: np.zeros(3))
    """Torque expected from outside, Nm, inertial axes."""


@dataclass(frozen=True)
class RodState:
    """What one plan of dipoles hands to the next."""

    observer: Observer | None = None
    """What is known about the third axis, while it is held."""


@dataclass(frozen=True)
class DipolePlan:
    """Dipoles for the coming period."""

    dipole: Array
    """A m^2, shape (k,)."""
    torque: Vector3
    """What they will do at its start, Nm, body axes."""


@dataclass(frozen=True)
class Situation:
    """The craft against its reference, in body axes."""

    J: Matrix3
    """Inertia as it is believed, kg m^2."""
    phi: Vector3
    """Attitude error, rad."""
    rate: Vector3
    """Rate relative to the reference, rad/s."""
    excess: Vector3
    """Momentum beyond what turning with the reference takes, Nms."""
    n_ref: Vector3 | None
    """The reference's own n: along it no momentum may be left on arrival."""
    external: Vector3
    """Torque expected from outside, Nm."""


@dataclass(frozen=True, eq=False)
class RodPlanner:
    """The dipoles of one spacecraft."""

    spacecraft: Spacecraft
    """As it is believed to be."""
    settings: RodSettings
    period: float
    """Control period, s."""

    def plan(
        self,
        measurement: Measurement,
        field_B: Vector3,
        aim: Aim,
        memory: RodState | None,
        known: Known | None = None,
    ) -> tuple[DipolePlan, RodState]:
        """Dipoles in a field (T, body axes), with what the planner of torques may know better."""
        now = self._situation(measurement, aim, known or Known(self.spacecraft.J))
        if now.n_ref is None:
            return self._allocated(field_B, self._unload(now), None), RodState()
        if self._near(now):
            return self._held(now, field_B, memory or RodState())
        wanted = -float(now.n_ref @ now.excess) * self._frequency
        torque = with_part(self._unload(now), now.n_ref, wanted)
        return self._allocated(field_B, torque, now.n_ref), RodState()

    def _situation(self, measurement: Measurement, aim: Aim, known: Known) -> Situation:
        craft, R = self.spacecraft, rotation_matrix(measurement.q)
        from_ref, n = R.T @ rotation_matrix(aim.q), craft.unactuated
        rate = measurement.omega - from_ref @ aim.omega
        return Situation(
            J=known.J,
            phi=2.0 * error_quaternion(measurement.q, aim.q)[1:],
            rate=rate,
            excess=known.J @ rate + craft.A @ (craft.Js * measurement.wheel_speed),
            n_ref=None if n is None else from_ref @ n,
            external=R.T @ known.external_N,
        )

    def _near(self, now: Situation) -> bool:
        """Whether the reference is held, or about to be: near it, and slow."""
        near = np.deg2rad(self.settings.near_deg)
        slow = near * self._frequency
        return bool(np.linalg.norm(now.phi) <= near and np.linalg.norm(now.rate) <= slow)

    def _held(
        self, now: Situation, field_B: Vector3, memory: RodState
    ) -> tuple[DipolePlan, RodState]:
        """The dipoles that hold the third axis, and unload with what is left."""
        craft, n = self.spacecraft, self.spacecraft.unactuated
        assert n is not None
        row = now.J @ n  # n'J, J being symmetric
        inertia = float(n @ row)
        axis = ThirdAxis(float(row @ now.phi) / inertia, float(row @ now.rate) / inertia, inertia)
        observer = observed(memory.observer, axis, self._frequency, self.period)
        known = float(n @ now.external)
        most = capability(craft.rods.axes, craft.rods.dipole_max, field_B, n)
        wanted = wanted_torque(axis, self._frequency, known + observer.external, most)
        plan = self._allocated(field_B, with_part(self._unload(now), n, wanted), n)
        given = float(n @ plan.torque) + known
        return plan, RodState(expected(observer, inertia, given, self.period))

    def _allocated(self, field_B: Vector3, torque: Vector3, first: Vector3 | None) -> DipolePlan:
        rods = self.spacecraft.rods
        dipole = allocate(rods.axes, rods.dipole_max, field_B, torque, first)
        return DipolePlan(dipole, rod_torque(rods.axes, dipole, field_B))

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
