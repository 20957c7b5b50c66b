"""A spacecraft as numbers: what its model file says, and nothing about how it was read."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from .arrays import Array, Matrix3, Vector3, Vectors3, WheelAxes, WheelVector, WheelVectors
from .envelope import TorqueEnvelope
from .magnetorquers import NO_RODS, Magnetorquers
from .units import Units, units_for

RANK_TOLERANCE = 1e-6  # relative singular value below which wheel axes count as dependent


@dataclass(frozen=True)
class Surface:
    """Outer faces, for drag and solar pressure; k faces, body axes, positions from the centre of
    mass of the whole spacecraft."""

    centre_B: Array
    """Centre of each face, m, shape (k, 3)."""
    normal_B: Array
    """Outward unit normal of each face, shape (k, 3)."""
    area: Array
    """Area of each face, m^2, shape (k,)."""
    drag_coefficient: float = 2.2
    reflectivity: float = 0.3


NO_SURFACE = Surface(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


@dataclass(frozen=True)
class Spacecraft:
    """A rigid spacecraft with m reaction wheels, and magnetic rods if it has any.

    Angular momentum about the centre of mass, body axes: H_B = J w + A (Js * Omega).
    """

    name: str
    mass: float
    """kg, rotors included."""
    J: Matrix3
    """kg m^2, body axes, about the centre of mass, rotors included and locked."""
    wheel_names: tuple[str, ...]
    A: WheelAxes
    """Unit spin axes, body axes, one per column, shape (3, m)."""
    Js: WheelVector
    """Spin inertia of each rotor, kg m^2."""
    torque_max: WheelVector
    """Nm; inf where the file gives none (likewise below)."""
    torque_rate_max: WheelVector
    """Nm/s."""
    speed_max: WheelVector
    """rad/s, relative to the hub."""
    viscous: WheelVector
    """Viscous friction of each wheel, Nms/rad."""
    coulomb: WheelVector
    """Coulomb friction of each wheel, Nm."""
    nominal_factors: Vector3 = field(default_factory=lambda: np.array([1.0, 1.0, 1.0]))
    """What the designer believes of J's diagonal, as a factor per axis (see `nominal`)."""
    surface: Surface = NO_SURFACE
    rods: Magnetorquers = NO_RODS
    envelopes: tuple[TorqueEnvelope | None, ...] = ()
    """What is left of each wheel's driving torque at speed; empty where all wheels keep theirs."""
    fingerprint: str = ""
    """Hash of the dynamics (J, A, Js, limits, friction): learned weights belong to one of these,
    with rods or without, which change nothing that was learned."""

    def __getstate__(self) -> dict[str, Any]:
        """The fields alone: what was computed from them makes no other spacecraft of it."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @property
    def wheels(self) -> int:
        """Number of wheels, m."""
        return len(self.wheel_names)

    @property
    def J_hub(self) -> Matrix3:
        """J - A diag(Js) A': the inertia that wheel torque accelerates."""
        return self.J - (self.A * self.Js) @ self.A.T

    @cached_property
    def actuation_rank(self) -> int:
        """Number of axes that the wheels span: 3 is fully actuated."""
        return int(np.linalg.matrix_rank(self.A, tol=RANK_TOLERANCE))

    @cached_property
    def unactuated(self) -> Vector3 | None:
        """Unit vector n that no wheel can push (n'A = 0), or None unless exactly one axis misses.

        Its sign makes the largest component positive. Admissible zero-momentum rates satisfy
        n'J w = 0: their plane has the normal J n.
        """
        if self.actuation_rank != 2:
            return None
        n: Vector3 = np.linalg.svd(self.A)[0][:, 2]
        return n * np.sign(n[np.argmax(np.abs(n))])

    @property
    def loop_normal(self) -> Vector3 | None:
        """Unit vector along J n, or None unless exactly one axis misses.

        Without momentum all rates lie in the plane with this normal, so an attitude error along it
        is removed only by a loop in that plane. It is n itself where n is a principal axis.
        """
        n = self.unactuated
        if n is None:
            return None
        normal: Vector3 = self.J @ n
        return normal / np.linalg.norm(normal)

    @property
    def momentum_max(self) -> WheelVector:
        """Momentum each wheel can store, Js * speed_max, Nms."""
        return self.Js * self.speed_max

    @property
    def spin_up_time(self) -> WheelVector:
        """Time from rest to the speed limit at full torque, s; nan without either limit."""
        with np.errstate(invalid="ignore"):
            return self.momentum_max / self.torque_max

    @property
    def own_units(self) -> Units:
        """The units in which it is as large and as quick as the benchmark (see `units`)."""
        return units_for(float(np.trace(self.J)) / 3.0, float(np.min(self.torque_max)))

    def in_units(self, units: Units) -> "Spacecraft":
        """The same spacecraft in other units of time and inertia; mass and surface stay in SI."""
        return replace(
            self,
            J=self.J / units.inertia,
            Js=self.Js / units.inertia,
            torque_max=self.torque_max / units.torque,
            torque_rate_max=self.torque_rate_max / units.torque_rate,
            speed_max=self.speed_max / units.rate,
            viscous=self.viscous / units.momentum,
            coulomb=self.coulomb / units.torque,
            envelopes=tuple(e and e.in_units(units) for e in self.envelopes),
        )

    def torque_available(self, speed: WheelVectors, torque: WheelVectors) -> WheelVectors:
        """Largest size of the torques that the motors can give in their directions, Nm: within the
        envelope where they drive a wheel on, up to the limit where they brake it."""
        most = np.broadcast_to(self.torque_max, np.shape(speed)).copy()
        for i, envelope in enumerate(self.envelopes):
            if envelope is not None:
                driving = speed[..., i] * torque[..., i] > 0.0
                driven = envelope.available(speed[..., i])
                most[..., i] = np.where(driving, driven, most[..., i])
        return most

    def inside_envelopes(self) -> "Spacecraft":
        """The same with constant limits of torque and speed that keep inside all envelopes.

        Of each wheel's the pair by which half a turn about its axis ends soonest (see
        `TorqueEnvelope.fastest_box`): what a planner that knows no envelope may count on, always.
        """
        about = np.einsum("im,ij,jm->m", self.A, self.J, self.A)
        rotation = self.Js**2 / (np.pi * about)
        torque, speed = self.torque_max.copy(), self.speed_max.copy()
        for i, envelope in enumerate(self.envelopes):
            if envelope is not None:
                torque[i], speed[i] = envelope.fastest_box(float(rotation[i]), float(speed[i]))
        return replace(self, torque_max=torque, speed_max=speed)

    def angular_momentum(self, omega_B: Vectors3, wheel_speed: WheelVectors) -> Vectors3:
        """H_B = J w + A (Js * Omega), Nms, body axes, batches in the leading axes."""
        return omega_B @ self.J.T + (wheel_speed * self.Js) @ self.A.T


def with_rods_on_for(share: float, craft: Spacecraft) -> Spacecraft:
    """The spacecraft with rods that are off for the rest of each period: what they give in the
    mean."""
    if share == 1.0:
        return craft
    return replace(craft, rods=replace(craft.rods, dipole_max=share * craft.rods.dipole_max))


def nominal(
    truth: Spacecraft,
    factors: Sequence[float] | Vector3 | None = None,
    mismatch: float = 1.0,
) -> Spacecraft:
    """What the controller believes: J's diagonal times stated factors, off-diagonals dropped.

    J_nominal = J + mismatch (diag(factors * diag J) - J): mismatch 0 is the true inertia, 1 the
    stated belief, 2 a belief twice as wrong. `factors` default to the model file's own
    (`nominal_inertia_factors`), else to 1. Torque limits that fall with speed are believed constant
    (`inside_envelopes`).
    """
    factors = truth.nominal_factors if factors is None else np.asarray(factors, float)
    believed = np.diag(factors * np.diag(truth.J))
    return replace(truth.inside_envelopes(), J=truth.J + mismatch * (believed - truth.J))
