"""From an MJCF file to a `Spacecraft` and the compiled model that the plant steps."""

import hashlib
import os.path
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array, Matrix3, Vector3
from simsat.control.ground.errors import ModelError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf.identity import model_identity
from simsat.mjcf.refusals import find_bus, refuse_joints, refuse_options
from simsat.mjcf.shapes import Shape, read_shapes, read_surface
from simsat.mjcf.wheels import WheelDrive, numeric, read_wheels


@dataclass(frozen=True)
class Model:
    """A spacecraft file, read: what the plant steps, and what everyone else needs to know."""

    spacecraft: Spacecraft
    mj: mujoco.MjModel
    free_joint: int
    bus: int
    """Body index of the bus."""
    wheels: tuple[WheelDrive, ...]
    passive_joints: tuple[str, ...]
    """Joints without an actuator (panels, slosh, a failed wheel), unknown to the controller."""
    body_names: tuple[str, ...]
    shapes: tuple[Shape, ...]
    identity: str
    """Hash of the compiled model: includes and assets count, the places of files do not."""


def read_model(path: Path | str) -> Model:
    """Read a spacecraft from an MJCF file.

    Raises `ModelError` if the file is missing or broken (MuJoCo's message names element and line),
    or describes something that MuJoCo would fly wrongly (`refusals`).
    """
    path = Path(path)
    if os.path.isdir(path):
        raise ModelError(f"'{path}' is a folder; name the MJCF file in it")
    if not os.path.isfile(path):
        raise ModelError(f"no model file at '{path}'")
    try:
        return interpret(mujoco.MjModel.from_xml_path(str(path)), path.stem)
    except ValueError as error:
        raise ModelError(f"'{path}': {' '.join(str(error).split())}") from error
    except ModelError as error:
        raise ModelError(f"'{path}': {error}") from error


def read_compiled(model: Any) -> Model:
    """Read a spacecraft from a `mujoco.MjModel`, or a `mujoco.MjSpec`, which is compiled.

    Raises `ModelError` as `read_model` does, also for anything else.
    """
    if isinstance(model, mujoco.MjSpec):
        try:
            model = model.compile()
        except ValueError as error:
            sentence = " ".join(str(error).split())
            raise ModelError(f"the MjSpec can't be compiled: {sentence}") from error
    if not isinstance(model, mujoco.MjModel):
        raise ModelError(
            f"a {type(model).__name__} is no spacecraft: give a name in models/, the path of an "
            "MJCF file, a mujoco.MjModel or a mujoco.MjSpec"
        )
    name = model.names.partition(b"\0")[0].decode() or "model"
    return interpret(model, name)


def interpret(m: mujoco.MjModel, name: str) -> Model:
    """Read a spacecraft from a compiled MuJoCo model (for models built or edited with `MjSpec`)."""
    identity = model_identity(m)
    refuse_options(m)
    free = find_bus(m)
    bus = int(m.jnt_bodyid[free])
    wheels = read_wheels(m)
    refuse_joints(m, free, wheels)
    d = mujoco.MjData(m)
    mujoco.mj_forward(m, d)
    driven = {wheel.joint for wheel in wheels}
    return Model(
        spacecraft=_spacecraft(m, d, name, free, bus, wheels),
        mj=m,
        free_joint=free,
        bus=bus,
        wheels=wheels,
        passive_joints=tuple(
            m.joint(j).name or f"joint_{j}" for j in range(m.njnt) if j != free and j not in driven
        ),
        body_names=tuple(m.body(b).name or f"body_{b}" for b in range(m.nbody)),
        shapes=read_shapes(m),
        identity=identity,
    )


def _spacecraft(
    m: mujoco.MjModel,
    d: mujoco.MjData,
    name: str,
    free: int,
    bus: int,
    wheels: tuple[WheelDrive, ...],
) -> Spacecraft:
    mass = float(m.body_subtreemass[bus])
    dofs = [wheel.dof for wheel in wheels]
    M = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, M)
    R_BN = d.xmat[bus].reshape(3, 3).T
    factors = numeric(m, "nominal_inertia_factors")
    if factors is not None and (factors.shape != (3,) or not np.all(factors > 0.0)):
        raise ModelError("numeric 'nominal_inertia_factors' must be three numbers above zero")
    parts: dict[str, Array] = {
        "J": _central_inertia(m, d, M, free, bus, mass, R_BN),
        "A": np.stack([R_BN @ d.xaxis[wheel.joint] for wheel in wheels], axis=1),
        "Js": np.diag(M)[dofs],
        "torque_max": np.array([wheel.torque_max for wheel in wheels]),
        "torque_rate_max": np.array([wheel.torque_rate_max for wheel in wheels]),
        "speed_max": np.array([wheel.speed_max for wheel in wheels]),
        "viscous": np.array(m.dof_damping[dofs], float),
        "coulomb": np.array(m.dof_frictionloss[dofs], float),
        "nominal_factors": np.ones(3) if factors is None else factors,
    }
    return Spacecraft(
        name=name,
        mass=mass,
        wheel_names=tuple(wheel.name for wheel in wheels),
        surface=read_surface(m, d, bus, wheels),
        fingerprint=_fingerprint(parts),
        **parts,
    )


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


def _fingerprint(parts: dict[str, Array]) -> str:
    text = ";".join(f"{key}={np.array2string(parts[key], precision=9)}" for key in sorted(parts))
    return hashlib.sha256(text.encode()).hexdigest()[:16]
