"""Reaction wheels of an MJCF file: an actuator on a hinge joint of the bus."""

import math
from dataclasses import dataclass
from enum import Enum

import mujoco
import numpy as np

from simsat.control.ground.errors import ModelError

SPEED_SUSPICIOUS = 3000.0  # rad/s, 28,600 rpm: no reaction wheel turns faster
RPM = 2.0 * math.pi / 60.0  # rad/s


class Drive(Enum):
    """What an actuator's control means."""

    TORQUE = "the control is the torque (<motor>)"
    RATE = "the control is the torque rate, the activation the torque (dyntype='integrator')"


@dataclass(frozen=True)
class WheelDrive:
    """Where a wheel sits in MuJoCo's arrays, and what its actuator can do."""

    name: str
    actuator: int
    joint: int
    qpos: int
    dof: int
    activation: int | None
    """Index into `act`; None for a plain motor."""
    drive: Drive
    gain: float
    """Nm at the rotor per unit of control (TORQUE) or of activation (RATE)."""
    torque_max: float
    torque_rate_max: float
    speed_max: float


def read_wheels(m: mujoco.MjModel) -> tuple[WheelDrive, ...]:
    """Every actuator as a wheel, in the file's order.

    Raises `ModelError` on an actuator that drives no wheel and on a file without wheels.
    """
    if m.nu == 0:
        raise ModelError(
            "the file has no wheel: give it a hinge joint on a rotor body and an <actuator> "
            "that drives it"
        )
    wheels = tuple(_read_wheel(m, i) for i in range(m.nu))
    for k, wheel in enumerate(wheels):
        for other in wheels[:k]:
            if other.joint == wheel.joint:
                raise ModelError(
                    f"actuators {_actuator(m, other.actuator)} and {_actuator(m, wheel.actuator)} "
                    f"both drive joint '{wheel.name}'; a wheel has one motor"
                )
    if len(wheels) > 6:
        raise ModelError(f"the file has {len(wheels)} wheels; 1 to 6 are supported")
    return wheels


def _actuator(m: mujoco.MjModel, i: int) -> str:
    return f"'{m.actuator(i).name}'" if m.actuator(i).name else f"number {i + 1}"


def _read_wheel(m: mujoco.MjModel, i: int) -> WheelDrive:
    joint = _driven_hinge(m, i)
    name = m.joint(joint).name
    drive, gain = _drive(m, i)
    return WheelDrive(
        name=name,
        actuator=i,
        joint=joint,
        qpos=int(m.jnt_qposadr[joint]),
        dof=int(m.jnt_dofadr[joint]),
        activation=int(m.actuator_actadr[i]) if drive is Drive.RATE else None,
        drive=drive,
        gain=gain,
        torque_max=_torque_max(m, i, joint, drive, gain),
        torque_rate_max=_torque_rate_max(m, i, drive, gain),
        speed_max=_speed_max(m, name),
    )


def _driven_hinge(m: mujoco.MjModel, i: int) -> int:
    if m.actuator_trntype[i] != mujoco.mjtTrn.mjTRN_JOINT:
        raise ModelError(
            f"actuator {_actuator(m, i)} drives no wheel: it must name a hinge joint (joint='...')"
        )
    joint = int(m.actuator_trnid[i, 0])
    name = m.joint(joint).name
    if not name:
        raise ModelError(
            f"the joint of actuator {_actuator(m, i)} has no name; every wheel needs one"
        )
    if m.jnt_type[joint] != mujoco.mjtJoint.mjJNT_HINGE:
        kind = mujoco.mjtJoint(m.jnt_type[joint]).name.removeprefix("mjJNT_").lower()
        raise ModelError(
            f"actuator {_actuator(m, i)} drives joint '{name}', a {kind} joint; "
            "a wheel is a hinge joint (type='hinge')"
        )
    return joint


def _drive(m: mujoco.MjModel, i: int) -> tuple[Drive, float]:
    plain = (
        m.actuator_gaintype[i] == mujoco.mjtGain.mjGAIN_FIXED
        and m.actuator_biastype[i] == mujoco.mjtBias.mjBIAS_NONE
    )
    gain = float(m.actuator_gainprm[i, 0] * m.actuator_gear[i, 0])
    dynamics = m.actuator_dyntype[i]
    if plain and gain > 0.0 and dynamics == mujoco.mjtDyn.mjDYN_NONE:
        return Drive.TORQUE, gain
    if plain and gain > 0.0 and dynamics == mujoco.mjtDyn.mjDYN_INTEGRATOR:
        return Drive.RATE, gain
    raise ModelError(
        f"actuator {_actuator(m, i)} is no torque motor: use <motor>, or <general "
        "dyntype='integrator' gainprm='1'> whose control is the torque rate (gain above 0, no bias)"
    )


def _bound(m: mujoco.MjModel, i: int, what: str, limited: int, bounds: np.ndarray) -> float:
    """Half-width of a symmetric range, inf if there is none."""
    if not limited:
        return math.inf
    low, high = map(float, bounds)
    if not math.isclose(-low, high, rel_tol=1e-9) or high < 0.0:
        raise ModelError(
            f"actuator {_actuator(m, i)}: {what} {low:g} {high:g} must be symmetric ('-0.05 0.05')"
        )
    return high


def _torque_max(m: mujoco.MjModel, i: int, joint: int, drive: Drive, gain: float) -> float:
    force = _bound(m, i, "forcerange", m.actuator_forcelimited[i], m.actuator_forcerange[i])
    clamp = _bound(m, i, "actuatorfrcrange of its joint", m.jnt_actfrclimited[joint],
                   m.jnt_actfrcrange[joint])  # fmt: skip
    if drive is Drive.TORQUE:
        command = _bound(m, i, "ctrlrange", m.actuator_ctrllimited[i], m.actuator_ctrlrange[i])
    else:
        command = _bound(m, i, "actrange", m.actuator_actlimited[i], m.actuator_actrange[i])
    return min(force * float(m.actuator_gear[i, 0]), clamp, command * gain)


def _torque_rate_max(m: mujoco.MjModel, i: int, drive: Drive, gain: float) -> float:
    if drive is Drive.TORQUE:
        return math.inf
    return gain * _bound(m, i, "ctrlrange", m.actuator_ctrllimited[i], m.actuator_ctrlrange[i])


def _speed_max(m: mujoco.MjModel, wheel: str) -> float:
    """Speed limit (rad/s) from <custom><numeric name='[WHEEL.]speed_limit_rpm' data='...'/>."""
    for name in (f"{wheel}.speed_limit_rpm", f"{wheel}.speed_limit_rad_s",
                 "speed_limit_rpm", "speed_limit_rad_s"):  # fmt: skip
        values = numeric(m, name)
        if values is None:
            continue
        unit = RPM if name.endswith("rpm") else 1.0
        speed = float(values[0]) * unit
        if not speed > 0.0 or len(values) != 1:
            raise ModelError(f"numeric '{name}' must be one number above zero")
        if speed > SPEED_SUSPICIOUS:
            raise ModelError(
                f"numeric '{name}' = {values[0]:g} means {speed / RPM:,.0f} rpm for '{wheel}'; "
                f"at most {SPEED_SUSPICIOUS / RPM:,.0f} rpm is believed: is the unit right?"
            )
        return speed
    return math.inf


def numeric(m: mujoco.MjModel, name: str) -> np.ndarray | None:
    """Values of <custom><numeric name=.../>, or None if the file has no such entry."""
    try:
        return np.array(m.numeric(name).data, float)
    except KeyError:
        return None
