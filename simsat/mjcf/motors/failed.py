"""Wheels that have seized: a rotor that a file declares failed is fixed to the bus.

    <custom><text name="failed_wheels" data="wheel_2 wheel_4"/></custom>

Joint and motor are taken out before MuJoCo compiles the file, so that what is flown is one rigid
body with the rotor in it: no constraint that would yield, no friction to solve. (A wheel whose
motor alone is dead goes on turning: that is `unused_actuators`.)
"""

from collections.abc import Iterator

import mujoco

from simsat.control.ground.errors import ModelError
from simsat.mjcf.custom import FAILED, LOCKED, listed, meant, text

INSIDE = 3  # MuJoCo's group of geoms that are inside, not drawn by default; any but 0 is no face


def with_failed_locked(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """A copy in which the rotors of the wheels that the file declares failed are fixed to the bus;
    the same object where it declares none.

    Raises `ModelError` on a name that no wheel has.
    """
    declared = [entry for entry in spec.texts if entry.name == FAILED]
    if any(entry.name == LOCKED for entry in spec.texts):
        raise ModelError(
            f"text '{LOCKED}' is the mark of a compiled model; to lock a wheel write '{FAILED}'"
        )
    if not declared:
        return spec
    spec = spec.copy()
    for entry in [entry for entry in spec.texts if entry.name == FAILED]:
        names = tuple(dict.fromkeys(entry.data.split()))
        _refuse_unknown(spec, names)
        for name in names:
            _lock(spec, name)
        entry.name, entry.data = LOCKED, " ".join(names)
    for keyframe in list(spec.keys):
        spec.delete(keyframe)  # they are as long as the joints were, and of no effect
    return spec


def failed_wheels(m: mujoco.MjModel) -> tuple[str, ...]:
    """Names of the wheels that were locked before the model was compiled.

    Raises `ModelError` if a model declares failed wheels and was compiled by others: its joints
    can't be taken out any more.
    """
    if (names := text(m, FAILED)) is not None:
        raise ModelError(
            f"text '{FAILED}' names {listed(names.split())}, but a compiled model can't lose a "
            "joint: give the MJCF file or a mujoco.MjSpec, or take joint and motor out before "
            "compiling"
        )
    return tuple((text(m, LOCKED) or "").split())


def _refuse_unknown(spec: mujoco.MjSpec, names: tuple[str, ...]) -> None:
    wheels = [name for name in dict.fromkeys(motor.target for motor in _motors(spec)) if name]
    unknown = [name for name in names if name not in wheels]
    if unknown:
        raise ModelError(
            f"text '{FAILED}' names {listed(unknown)}, but the wheels' joints are "
            f"{listed(wheels)}{meant(unknown[0], wheels)}"
        )


def _motors(spec: mujoco.MjSpec) -> Iterator[mujoco.MjsActuator]:
    for actuator in spec.actuators:
        if actuator.trntype == mujoco.mjtTrn.mjTRN_JOINT:
            yield actuator


def _lock(spec: mujoco.MjSpec, name: str) -> None:
    """Take out a wheel's joint, its motor, and the sensors that look at them."""
    motors = [motor for motor in _motors(spec) if motor.target == name]
    gone = {name, *(motor.name for motor in motors)}
    for sensor in [sensor for sensor in spec.sensors if sensor.objname in gone]:
        spec.delete(sensor)
    for motor in motors:
        spec.delete(motor)
    joint = spec.joint(name)
    _hide(joint.parent)
    spec.delete(joint)


def _hide(body: mujoco.MjsBody) -> None:
    """What is fixed to a rotor sits inside the hull: none of its geoms is an outer face."""
    for geom in body.geoms:
        geom.group = geom.group or INSIDE
    for child in body.bodies:
        _hide(child)
