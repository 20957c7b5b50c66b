"""From an MJCF file to a `Spacecraft` and the compiled model that the plant steps."""

import os.path
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from simsat.control.ground.errors import ModelError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf.custom import misspelt, unused_actuators
from simsat.mjcf.engine import COMPILED, compiled, parsed, translated
from simsat.mjcf.identity import model_identity
from simsat.mjcf.ignored import without_effect
from simsat.mjcf.magnetorquers import wrong_rods
from simsat.mjcf.motors.failed import failed_wheels, with_failed_locked
from simsat.mjcf.numbers import at_reference, nominal_factors, read_spacecraft
from simsat.mjcf.refusals.faults import Faults
from simsat.mjcf.refusals.foreign import foreign_settings, not_finite
from simsat.mjcf.refusals.joints import dependent_joints, find_bus, wrong_joints
from simsat.mjcf.refusals.options import wrong_options
from simsat.mjcf.refusals.ranges import empty_ranges
from simsat.mjcf.refusals.rotors import coasting_rotors, unbelieved_speeds, wrong_rotors
from simsat.mjcf.refusals.size import too_large
from simsat.mjcf.refusals.timestep import (
    unseen_nutation,
    unseen_swings,
    unseen_turns,
    unsuited_timestep,
    wrong_timestep,
)
from simsat.mjcf.rotors import Rotor, read_rotor
from simsat.mjcf.self_test.laws import flown_otherwise
from simsat.mjcf.shapes import Shape, read_shapes, read_surface, wrong_coefficients
from simsat.mjcf.stepped import to_step
from simsat.mjcf.wheels import WheelDrive, read_wheels


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
    """Joints without an actuator (panels, slosh, a coasting rotor), unknown to the controller."""
    failed_wheels: tuple[str, ...]
    """Wheels that the file declares failed: their rotors are fixed to the bus."""
    unused_actuators: tuple[str, ...]
    """Actuators that the file declares unused: they give no force, their joints are passive."""
    ignored: tuple[str, ...]
    """What the file holds without effect on a flight."""
    warnings: tuple[str, ...]
    """What MuJoCo warned of as it compiled the file."""
    body_names: tuple[str, ...]
    shapes: tuple[Shape, ...]
    identity: str
    """Hash of the compiled model: includes and assets count, the places of files do not."""

    def to_step(self) -> mujoco.MjModel:
        """A copy for MuJoCo to step (`stepped`)."""
        return to_step(self.mj, [self.mj.actuator(name).id for name in self.unused_actuators])


def read_model(path: Path | str) -> Model:
    """Read a spacecraft from an MJCF file.

    Raises `ModelError` if the file is missing or broken (MuJoCo's message names element and line),
    or describes something that is not modelled here or that MuJoCo would fly wrongly (`interpret`).
    """
    path = Path(path)
    if os.path.isdir(path):
        raise ModelError(f"'{path}' is a folder; name the MJCF file in it")
    if not os.path.isfile(path):
        raise ModelError(f"no model file at '{path}'")
    try:
        oversized = Faults()
        oversized.note(too_large(path) if path.suffix != COMPILED else ())
        oversized.raise_if_any()
        source, warnings = parsed(path)
        return interpret(source, path.stem, warnings)
    except ModelError as error:
        sentence, *faults = error.args
        raise ModelError(f"'{path}': {sentence}", *faults) from error


def read_compiled(model: Any) -> Model:
    """Read a spacecraft from a `mujoco.MjModel`, or a `mujoco.MjSpec`, which is compiled.

    Raises `ModelError` as `read_model` does, also for anything else.
    """
    if isinstance(model, mujoco.MjSpec):
        return interpret(model, model.modelname or "model")
    if isinstance(model, mujoco.MjModel):
        return interpret(model, model.names.partition(b"\0")[0].decode() or "model")
    raise ModelError(
        f"a {type(model).__name__} is no spacecraft: give a name in models/, the path of an "
        "MJCF file, a mujoco.MjModel or a mujoco.MjSpec"
    )


def interpret(
    source: mujoco.MjModel | mujoco.MjSpec, name: str, warnings: tuple[str, ...] = ()
) -> Model:
    """Read a spacecraft from a compiled MuJoCo model, or from an `MjSpec` built or edited in code.

    Raises `ModelError` with all faults of the model: settings that nobody here interprets and
    things that would be flown wrongly (`refusals`), and laws that MuJoCo's own flight of it breaks
    (`self_test`). `warnings` are MuJoCo's about the file.
    """
    faults = Faults()
    if isinstance(source, mujoco.MjSpec):
        m, more = compiled(with_failed_locked(source))
        warnings = (*warnings, *more)
        faults.note(empty_ranges(source))
    else:
        m = source
    failed = failed_wheels(m)
    faults.note(not_finite(m, warnings))
    faults.raise_if_any()  # no number below means anything
    unused: frozenset[int] = frozenset()
    with faults.noting():
        unused = unused_actuators(m)
    with translated():
        parts = _parts(m, unused, failed, faults)
        craft = _flown(m, to_step(m, unused), name, parts, faults)
    passive = [j for j in range(m.njnt) if j not in (parts.free, *parts.driven)]
    return Model(
        spacecraft=craft,
        mj=m,
        free_joint=parts.free,
        bus=parts.bus,
        wheels=parts.wheels,
        passive_joints=tuple(m.joint(j).name or f"joint_{j}" for j in passive),
        failed_wheels=failed,
        unused_actuators=tuple(m.actuator(i).name for i in sorted(unused)),
        ignored=tuple(without_effect(m, parts.bus, parts.turning, (*craft.wheel_names, *failed))),
        warnings=warnings,
        body_names=tuple(m.body(b).name or f"body_{b}" for b in range(m.nbody)),
        shapes=read_shapes(m),
        identity=model_identity(m),
    )


@dataclass(frozen=True)
class _Parts:
    """What is what in a compiled model."""

    free: int
    bus: int
    wheels: tuple[WheelDrive, ...]
    rotors: dict[str, Rotor]
    """By the wheels' names, in their order."""
    turning: frozenset[int]
    """Bodies of all rotors, those of failed wheels too."""

    @property
    def driven(self) -> frozenset[int]:
        """Joints of the wheels."""
        return frozenset(wheel.joint for wheel in self.wheels)


def _parts(
    m: mujoco.MjModel, unused: Collection[int], failed: Collection[str], faults: Faults
) -> _Parts:
    """The parts of a model whose settings and structure are right. Raises `ModelError` if not."""
    faults.note(wrong_options(m))
    faults.note(wrong_coefficients(m))
    with faults.noting():
        nominal_factors(m)
    wheels = read_wheels(m, unused, faults)
    motors = {wheel.actuator for wheel in wheels}
    faults.note(foreign_settings(m, set(range(m.nactuator)) - motors))
    faults.note(misspelt(m, [*failed, *(wheel.name for wheel in wheels)]))
    rotors = {wheel.name: read_rotor(m, wheel.joint) for wheel in wheels}
    driven = {wheel.joint for wheel in wheels}
    free = bus = -1
    with faults.noting():
        free = find_bus(m)
        bus = int(m.jnt_bodyid[free])
        faults.note(wrong_joints(m, free, driven))
        faults.note(wrong_rotors(m, bus, rotors))
        faults.note(_wrong_steps(m, wheels, rotors))
        faults.note(wrong_rods(m, at_reference(m).d, bus))
    faults.raise_if_any()
    turning = coasting_rotors(m, bus, driven).union(*(rotor.bodies for rotor in rotors.values()))
    return _Parts(free, bus, wheels, rotors, turning)


def _wrong_steps(
    m: mujoco.MjModel, wheels: Collection[WheelDrive], rotors: Mapping[str, Rotor]
) -> Iterator[str]:
    """What is wrong with the time step; what moves too fast for it, where it is a step at all."""
    wrong = list(wrong_timestep(m))
    M = at_reference(m).M
    dependent = list(dependent_joints(m, M))
    yield from (*wrong, *dependent)
    if not wrong:
        yield from unseen_turns(m, rotors, {wheel.name: wheel.speed_max for wheel in wheels})
    if not wrong and not dependent:
        yield from unseen_swings(m, M)


def _flown(
    m: mujoco.MjModel, stepped: mujoco.MjModel, name: str, parts: _Parts, faults: Faults
) -> Spacecraft:
    """The spacecraft as numbers, of a model that MuJoCo flies by them as the plant would step it.

    Raises `ModelError` if it doesn't.
    """
    reference = at_reference(m)
    surface = read_surface(m, reference.d, parts.bus, parts.turning)
    craft = read_spacecraft(m, reference, name, parts.free, parts.wheels, surface)
    faults.note(unsuited_timestep(m, craft))
    faults.note(unbelieved_speeds(craft))
    faults.note(unseen_nutation(m, craft))
    faults.raise_if_any()
    rotors = list(parts.rotors.values())
    faults.note(flown_otherwise(stepped, parts.free, parts.wheels, rotors, craft))
    faults.raise_if_any()
    return craft
