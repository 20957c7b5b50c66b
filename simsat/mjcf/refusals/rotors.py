"""Refusals of rotors: each hangs rigidly on the bus, spins freely, is one body and in balance."""

import math
from collections.abc import Collection, Iterator, Mapping

import mujoco

from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf.custom import UNUSED
from simsat.mjcf.refusals.joints import joint_name
from simsat.mjcf.refusals.timestep import OUT_OF_BALANCE, describe_imbalance
from simsat.mjcf.rotors import Rotor, read_rotor, subtree
from simsat.mjcf.wheels import RPM

SPEED_SUSPICIOUS = 3000.0  # rad/s, 28,600 rpm: no reaction wheel turns faster


def wrong_rotors(m: mujoco.MjModel, bus: int, rotors: Mapping[str, Rotor]) -> Iterator[str]:
    """What no rotor of a wheel has (`rotors` by the name of the wheel)."""
    for name, rotor in rotors.items():
        body = int(m.jnt_bodyid[rotor.joint])
        if m.jnt_stiffness[rotor.joint] != 0.0:
            stiffness = m.jnt_stiffness[rotor.joint]
            yield f"wheel '{name}' has stiffness {stiffness:g}; a rotor spins freely"
        if m.jnt_limited[rotor.joint]:
            yield f"wheel '{name}' has a range; a rotor spins freely, remove it"
        if m.body_jntnum[body] != 1:
            yield f"the body of wheel '{name}' has {m.body_jntnum[body]} joints; a rotor has one"
        yield from _hung_wrongly(m, bus, body, name)
        yield from _moving_inside(m, rotor, name)
        if rotor.imbalance > OUT_OF_BALANCE:
            how, remedy = describe_imbalance(m, rotor, OUT_OF_BALANCE)
            yield (
                f"wheel '{name}' is imbalanced ({how}), a wheel by less than "
                f"{100.0 * OUT_OF_BALANCE:g} %: {remedy}, or, if it is no wheel, declare "
                f"<custom><text name='{UNUSED}' data='{_motor(m, rotor.joint)}'/></custom>"
            )


def unbelieved_speeds(craft: Spacecraft) -> Iterator[str]:
    """Speed limits beyond those of any wheel, and of so quick a craft's."""
    most = SPEED_SUSPICIOUS * max(1.0, craft.own_units.rate)
    for name, speed in zip(craft.wheel_names, craft.speed_max.tolist(), strict=True):
        if most < speed < math.inf:
            yield (
                f"the speed limit means {speed / RPM:,.0f} rpm for '{name}'; at most "
                f"{most / RPM:,.0f} rpm is believed: is the unit right?"
            )


def _motor(m: mujoco.MjModel, joint: int) -> str:
    """Name of the actuator that drives a joint."""
    joints = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    for i in range(m.nactuator):
        if int(m.actuator_trntype[i]) in joints and m.actuator_trnid[i, 0] == joint:
            return m.actuator(i).name or "NAME OF ITS MOTOR"
    return "NAME OF ITS MOTOR"


def _hung_wrongly(m: mujoco.MjModel, bus: int, body: int, name: str) -> Iterator[str]:
    support = int(m.body_weldid[m.body_parentid[body]])
    if support == bus:
        return
    if support == 0:
        yield (
            f"wheel '{name}' hangs on the world, not on the spacecraft '{m.body(bus).name}'; move "
            "its rotor into the bus, the world is scenery"
        )
        return
    joint = joint_name(m, int(m.body_jntadr[support]))
    yield (
        f"wheel '{name}' hangs on '{m.body(support).name}', which moves by joint '{joint}'; a "
        "wheel's axis is fixed in the bus, move its rotor there"
    )


def _moving_inside(m: mujoco.MjModel, rotor: Rotor, name: str) -> Iterator[str]:
    loose = subtree(m, int(m.jnt_bodyid[rotor.joint])) - rotor.bodies
    joints = [joint_name(m, j) for j in range(m.njnt) if int(m.jnt_bodyid[j]) in loose]
    if joints:
        yield (
            f"the rotor of wheel '{name}' carries joint '{joints[0]}'; a rotor turns as one rigid "
            "body, remove the joint"
        )


def coasting_rotors(m: mujoco.MjModel, bus: int, driven: Collection[int]) -> frozenset[int]:
    """Bodies that turn as a wheel does, but without a motor: a failed one's rotor."""
    bodies: set[int] = set()
    for j in range(m.njnt):
        if j in driven or m.jnt_type[j] != mujoco.mjtJoint.mjJNT_HINGE:
            continue
        rotor = read_rotor(m, j)
        if not any(wrong_rotors(m, bus, {joint_name(m, j): rotor})):
            bodies |= rotor.bodies
    return frozenset(bodies)
