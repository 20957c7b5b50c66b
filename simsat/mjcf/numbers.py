"""From a compiled model and its wheels to a `Spacecraft`: mass, J, A, Js, limits, friction."""

import hashlib
from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array, Matrix3, Vector3
from simsat.control.ground.envelope import TorqueEnvelope
from simsat.control.ground.errors import ModelError
from simsat.control.ground.spacecraft import Spacecraft, Surface
from simsat.mjcf.custom import numbers
from simsat.mjcf.magnetorquers import read_rods
from simsat.mjcf.wheels import WheelDrive


class Reference(NamedTuple):
    """A model at its reference: where everything is, and the joint-space mass matrix."""

    d: mujoco.MjData
    M: Array
    """kg, kg m, kg m^2; shape (nv, nv)."""


def at_reference(m: mujoco.MjModel) -> Reference:
    """Kinematics and mass matrix with every joint at its reference."""
    d = mujoco.MjData(m)
    mujoco.mj_fwdPosition(m, d)
    M = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, M)
    return Reference(d, M)


def read_spacecraft(
    m: mujoco.MjModel,
    reference: Reference,
    name: str,
    free: int,
    wheels: Sequence[WheelDrive],
    surface: Surface,
) -> Spacecraft:
    """The spacecraft as numbers. Raises `ModelError` on a wrong `nominal_inertia_factors`."""
    d, M = reference
    bus = int(m.jnt_bodyid[free])
    mass = float(m.body_subtreemass[bus])
    dofs = [wheel.dof for wheel in wheels]
    R_BN = d.xmat[bus].reshape(3, 3).T
    parts: dict[str, Array] = {
        "J": _central_inertia(m, d, M, free, bus, mass, R_BN),
        "A": np.stack([R_BN @ d.xaxis[wheel.joint] for wheel in wheels], axis=1),
        "Js": np.diag(M)[dofs],
        "torque_max": np.array([wheel.torque_max for wheel in wheels]),
        "torque_rate_max": np.array([wheel.torque_rate_max for wheel in wheels]),
        "speed_max": np.array([wheel.speed_max for wheel in wheels]),
        "viscous": np.array(m.dof_damping[dofs], float),
        "coulomb": np.array(m.dof_frictionloss[dofs], float),
        "nominal_factors": nominal_factors(m),
    }
    envelopes = tuple(wheel.envelope for wheel in wheels)
    return Spacecraft(
        name=name,
        mass=mass,
        wheel_names=tuple(wheel.name for wheel in wheels),
        surface=surface,
        rods=read_rods(m, d, bus),
        envelopes=envelopes if any(envelopes) else (),
        fingerprint=_fingerprint(parts, envelopes),
        **parts,
    )


def nominal_factors(m: mujoco.MjModel) -> Vector3:
    """What the designer believes of J's diagonal, 1 where the file says nothing."""
    factors = numbers(m, "nominal_inertia_factors")
    if factors is None:
        return np.array([1.0, 1.0, 1.0])
    if factors.shape != (3,) or not np.all((factors > 0.0) & np.isfinite(factors)):
        raise ModelError("numeric 'nominal_inertia_factors' must be three numbers above zero")
    return factors


def _central_inertia(
    m: mujoco.MjModel,
    d: mujoco.MjData,
    M: Array,
    free: int,
    bus: int,
    mass: float,
    R_BN: Matrix3,
) -> Matrix3:
    """J about the centre of mass: the free joint's block of the mass matrix, every other joint
    locked, moved from the body origin to the centre of mass (parallel axes)."""
    rotation = slice(m.jnt_dofadr[free] + 3, m.jnt_dofadr[free] + 6)
    c: Vector3 = R_BN @ (d.subtree_com[bus] - d.xpos[bus])
    J: Matrix3 = M[rotation, rotation] - mass * (c @ c * np.eye(3) - np.outer(c, c))
    return 0.5 * (J + J.T)


def _fingerprint(parts: dict[str, Array], envelopes: Sequence[TorqueEnvelope | None]) -> str:
    text = ";".join(f"{key}={np.array2string(parts[key], precision=9)}" for key in sorted(parts))
    if any(envelopes):  # else what was trained for a file stays its own
        text += f";envelopes={envelopes}"
    return hashlib.sha256(text.encode()).hexdigest()[:16]
