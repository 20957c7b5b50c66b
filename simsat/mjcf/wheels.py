"""Reaction wheels of an MJCF file: an actuator on a hinge joint of the bus."""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import mujoco
import numpy as np

from simsat.control.ground.envelope import TorqueEnvelope
from simsat.control.ground.errors import ModelError
from simsat.mjcf.custom import UNUSED
from simsat.mjcf.motors.envelopes import read_envelope
from simsat.mjcf.motors.speeds import RPM as RPM
from simsat.mjcf.motors.speeds import read_speed_limit
from simsat.mjcf.refusals.faults import Faults

WHEELS_MAX = 6


class Drive(Enum):
    """What an actuator's control means."""

    TORQUE = "the control is the torque (<motor>)"
    RATE = "the control is the torque rate, the activation the torque (dyntype='integrator')"


@dataclass(frozen=True)
class WheelDrive:
    """Where a wheel sits in MuJoCo's arrays, and what its actuator can do."""

    name: str
    actuator: int
    control: int
    """Index into `ctrl`, which has several entries for some actuators that are no wheel's."""
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
    envelope: TorqueEnvelope | None
    """What of the torque is left at speed; all of it without one."""


def read_wheels(
    m: mujoco.MjModel, unused: Collection[int], faults: Faults
) -> tuple[WheelDrive, ...]:
    """Every actuator but the unused ones as a wheel, in the file's order.

    Notes what makes an actuator no wheel's motor, and a file without wheels.
    """
    wheels: list[WheelDrive] = []
    used = [i for i in range(m.nactuator) if i not in unused]
    for i in used:
        with faults.noting():
            wheel = _read_wheel(m, i, faults)
            _refuse_second_motor(m, wheels, wheel)
            wheels.append(wheel)
    if not used:
        faults.note(
            [
                "the file has no wheel: give it a hinge joint on a rotor body and an <actuator> "
                "that drives it"
            ]
        )
    if len(used) > WHEELS_MAX:
        faults.note([f"the file has {len(used)} wheels; 1 to {WHEELS_MAX} are supported"])
    return tuple(wheels)


def _refuse_second_motor(
    m: mujoco.MjModel, wheels: Sequence[WheelDrive], wheel: WheelDrive
) -> None:
    for other in wheels:
        if other.joint == wheel.joint:
            raise ModelError(
                f"actuators {_actuator(m, other.actuator)} and {_actuator(m, wheel.actuator)} "
                f"both drive joint '{wheel.name}'; a wheel has one motor"
            )


def _actuator(m: mujoco.MjModel, i: int) -> str:
    return f"'{m.actuator(i).name}'" if m.actuator(i).name else f"number {i + 1}"


def _read_wheel(m: mujoco.MjModel, i: int, faults: Faults) -> WheelDrive:
    """One wheel; wrong limits are noted, an actuator that is no motor on a hinge is raised."""
    joint = _driven_hinge(m, i)
    name = m.joint(joint).name
    drive, gain = _drive(m, i)
    ranges = {
        what: _bound(m, i, what, limited, bounds, faults)
        for what, limited, bounds in _ranges(m, i, joint)
    }
    gear = abs(_gear(m, i))
    torques = [ranges["forcerange"] * gear, ranges["actuatorfrcrange of its joint"]]
    torques.append(gain * ranges["ctrlrange" if drive is Drive.TORQUE else "actrange"])
    speed_max, envelope = math.inf, None
    with faults.noting():
        speed_max = read_speed_limit(m, name)
    with faults.noting():
        envelope = read_envelope(m, name)
    if envelope is not None:
        envelope = envelope.capped(min(torques))
        torques.append(envelope.stall)
    return WheelDrive(
        name=name,
        actuator=i,
        control=int(m.actuator_ctrladr[i]),
        joint=joint,
        qpos=int(m.jnt_qposadr[joint]),
        dof=int(m.jnt_dofadr[joint]),
        activation=int(m.actuator_actadr[i]) if drive is Drive.RATE else None,
        drive=drive,
        gain=gain,
        torque_max=min(torques),
        torque_rate_max=gain * ranges["ctrlrange"] if drive is Drive.RATE else math.inf,
        speed_max=speed_max,
        envelope=envelope,
    )


def _driven_hinge(m: mujoco.MjModel, i: int) -> int:
    if m.actuator_trntype[i] != mujoco.mjtTrn.mjTRN_JOINT:
        raise ModelError(
            f"actuator {_actuator(m, i)} drives no wheel: it must name a hinge joint "
            f"(joint='...'); {_or_unused(m, i)}"
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
            f"a wheel is a hinge joint (type='hinge'); {_or_unused(m, i)}"
        )
    return joint


def _or_unused(m: mujoco.MjModel, i: int) -> str:
    """How to keep an actuator that is no wheel's: it is held at zero."""
    name = m.actuator(i).name
    return (
        f"to fly without it, declare <custom><text name='{UNUSED}' data='{name or 'NAME'}'/>"
        f"</custom>{'' if name else ' and give it that name'}"
    )


def _drive(m: mujoco.MjModel, i: int) -> tuple[Drive, float]:
    plain = (
        m.actuator_gaintype[i] == mujoco.mjtGain.mjGAIN_FIXED
        and m.actuator_biastype[i] == mujoco.mjtBias.mjBIAS_NONE
    )
    gain = float(m.actuator_gainprm[i, 0]) * _gear(m, i)
    dynamics = m.actuator_dyntype[i]
    if plain and gain > 0.0 and dynamics == mujoco.mjtDyn.mjDYN_NONE:
        return Drive.TORQUE, gain
    if plain and gain > 0.0 and dynamics == mujoco.mjtDyn.mjDYN_INTEGRATOR:
        return Drive.RATE, gain
    raise ModelError(
        f"actuator {_actuator(m, i)} is no torque motor: use <motor>, or <general "
        "dyntype='integrator' gainprm='1'> whose control is the torque rate (gain above 0, no "
        f"bias); {_or_unused(m, i)}"
    )


def _gear(m: mujoco.MjModel, i: int) -> float:
    return float(m.actuator_gear[m.actuator_outadr[i], 0])


def _ranges(m: mujoco.MjModel, i: int, joint: int) -> Iterator[tuple[str, bool, np.ndarray]]:
    """(name, whether it is on, bounds) of every range that limits a motor or its joint."""
    k = m.actuator_ctrladr[i]
    yield "ctrlrange", m.actuator_ctrllimited[k], m.actuator_ctrlrange[k]
    yield "forcerange", m.actuator_forcelimited[i], m.actuator_forcerange[i]
    yield "actrange", m.actuator_actlimited[i], m.actuator_actrange[i]
    yield (
        "actuatorfrcrange of its joint",
        m.jnt_actfrclimited[joint],
        m.jnt_actfrcrange[joint],
    )


def _bound(
    m: mujoco.MjModel, i: int, what: str, limited: bool, bounds: np.ndarray, faults: Faults
) -> float:
    """Half-width of a symmetric range, inf if there is none."""
    if not limited:
        return math.inf
    low, high = map(float, bounds)
    if not math.isclose(-low, high, rel_tol=1e-9) or not high > 0.0:
        faults.note(
            [
                f"actuator {_actuator(m, i)}: {what} {low:g} {high:g} must be symmetric about zero "
                "and not empty ('-0.05 0.05')"
            ]
        )
    return high
