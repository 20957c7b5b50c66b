"""Refusals of joints: the free one holds, the others belong to the spacecraft and lose energy."""

from collections.abc import Collection, Iterator

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import ModelError

SINGULAR = 1e-10  # share of a joint's inertia that is its own; round-off is 1e-16


def find_bus(m: mujoco.MjModel) -> int:
    """Joint index of the one free joint. Raises `ModelError` if there is none, or more."""
    free = [j for j in range(m.njnt) if m.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    if len(free) != 1:
        raise ModelError(
            f"the file has {len(free)} free bodies; a spacecraft is one body with a <freejoint/> "
            "directly in <worldbody>, everything else hangs on it"
        )
    return free[0]


def wrong_joints(m: mujoco.MjModel, free: int, driven: Collection[int]) -> Iterator[str]:
    """Joints that break momentum, or that belong to nothing of the spacecraft.

    `driven` are the wheels' joints, of which `rotors` says more.
    """
    if _is_held(m, free):
        yield (
            f"free joint '{joint_name(m, free)}' has damping, friction or stiffness (a <default>?):"
            " nothing holds a spacecraft; use <freejoint/>"
        )
    for j in range(m.njnt):
        if j == free:
            continue
        name = joint_name(m, j)
        if m.jnt_type[j] == mujoco.mjtJoint.mjJNT_BALL:
            yield f"joint '{name}' is a ball joint, which breaks momentum; use hinges"
        if j not in driven and m.body_rootid[m.jnt_bodyid[j]] != m.jnt_bodyid[free]:
            yield (
                f"joint '{name}' moves a body that hangs on the world, not on the spacecraft; the "
                "world is scenery and stands still, remove the joint"
            )
        yield from _feeds_energy(m, j, name)


def joint_name(m: mujoco.MjModel, j: int) -> str:
    """Its name, or its number in the file where it has none."""
    return m.joint(j).name or f"number {j + 1}"


def _is_held(m: mujoco.MjModel, free: int) -> bool:
    dofs = slice(m.jnt_dofadr[free], m.jnt_dofadr[free] + 6)
    held = m.dof_damping[dofs].any() or m.dof_frictionloss[dofs].any() or m.jnt_stiffness[free]
    return bool(held)


def _feeds_energy(m: mujoco.MjModel, j: int, name: str) -> Iterator[str]:
    dof = m.jnt_dofadr[j]
    for what, value in (
        ("damping", m.dof_damping[dof]),
        ("frictionloss", m.dof_frictionloss[dof]),
        ("stiffness", m.jnt_stiffness[j]),
    ):
        if value < 0.0:
            yield f"joint '{name}' has {what} {value:g}, which feeds motion; give 0 or more"


def dependent_joints(m: mujoco.MjModel, M: Array) -> Iterator[str]:
    """Joints that move the same bodies in the same way: how they share it is undetermined.

    `M` is the joint-space mass matrix; scaled to ones on its diagonal it is then singular. Where
    rounding leaves nothing of an inertia there, beside a part a million km away, it is refused too.
    """
    lost = np.flatnonzero(~(np.diag(M) > 0.0))
    if len(lost) > 0:
        name, inertia = joint_name(m, int(m.dof_jntid[lost[0]])), M[lost[0], lost[0]]
        yield (
            f"rounding leaves joint '{name}' the inertia {inertia:g}: the parts are too heavy or "
            "too far apart to be one spacecraft, are their units right?"
        )
        return
    scale = 1.0 / np.sqrt(np.diag(M))
    values, vectors = np.linalg.eigh(scale[:, None] * M * scale)
    if not values[0] > SINGULAR:
        shares = np.abs(vectors[:, 0])
        moving = dict.fromkeys(
            joint_name(m, int(j)) for j in m.dof_jntid[shares > 0.1 * shares.max()]
        )
        yield (
            f"joints {', '.join(map(repr, moving))} move the same bodies in the same way, or "
            "bodies without inertia; leave one"
        )
