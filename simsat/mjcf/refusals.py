"""What MuJoCo would fly, but fly wrongly: each is refused with its remedy.

Measured reasons: 33 deg of attitude error in 100 s under Euler or implicitfast with wheel bias,
2e-8 deg under RK4; an armature cuts a wheel's reaction on the bus by J/(J + armature) while the
momentum sensor looks fine; friction at the default solver tolerance leaks 2.5e-7 Nm, the size of
drag.
"""

from collections.abc import Sequence

import mujoco
import numpy as np

from simsat.control.ground.errors import ModelError
from simsat.mjcf.wheels import WheelDrive

FRICTION_TOLERANCE = 1e-12  # solver tolerance above which Coulomb friction leaks momentum
IMBALANCE_TIMESTEP = 5e-4  # s; a rotor off its axis is resolved only below this step
IMBALANCE_PRODUCT = 1e-5  # product of inertia over spin inertia; file numbers have 6 digits or more
IMBALANCE_OFFSET = 1e-9  # m; a rotor's centre of mass closer than this to its axis is on it


def refuse_options(m: mujoco.MjModel) -> None:
    """Raise `ModelError` on an <option> under which free flight is wrong."""
    option = m.opt
    if option.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        used = mujoco.mjtIntegrator(option.integrator).name.removeprefix("mjINT_")
        raise ModelError(f"<option integrator='{used}'>: attitude drifts by degrees; use 'RK4'")
    if np.any(option.gravity != 0.0):
        raise ModelError(
            f"<option gravity='{_row(option.gravity)}'>: a spacecraft in orbit is in free fall; "
            "use gravity='0 0 0' (gravity gradient is added by the simulator)"
        )
    if option.density != 0.0 or option.viscosity != 0.0 or np.any(option.wind != 0.0):
        raise ModelError(
            "<option density/viscosity/wind>: MuJoCo's fluid is not a thin atmosphere; leave them "
            "at 0 (drag is added by the simulator)"
        )
    if not option.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET:
        raise ModelError(
            "<flag autoreset>: MuJoCo would restart silently after a divergence; add "
            "<option><flag autoreset='disable'/></option>"
        )
    if not option.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT and _can_touch(m):
        raise ModelError(
            "<flag contact>: geoms of rotors and bus would collide; add "
            "<option><flag contact='disable'/></option>"
        )


def _can_touch(m: mujoco.MjModel) -> bool:
    return bool(np.any(m.geom_contype) and np.any(m.geom_conaffinity)) and m.ngeom > 1


def _row(values: np.ndarray) -> str:
    return " ".join(f"{v:g}" for v in values)


def find_bus(m: mujoco.MjModel) -> int:
    """Joint index of the one free joint. Raises `ModelError` if there is none, or more."""
    free = [j for j in range(m.njnt) if m.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    if len(free) != 1:
        raise ModelError(
            f"the file has {len(free)} free bodies; a spacecraft is one body with a <freejoint/> "
            "directly in <worldbody>, everything else hangs on it"
        )
    return free[0]


def refuse_joints(m: mujoco.MjModel, free: int, wheels: Sequence[WheelDrive]) -> None:
    """Raise `ModelError` on joints that break momentum or that no wheel has."""
    driven = {wheel.joint for wheel in wheels}
    for j in range(m.njnt):
        name, dof, kind = m.joint(j).name or f"number {j + 1}", m.jnt_dofadr[j], m.jnt_type[j]
        if kind == mujoco.mjtJoint.mjJNT_BALL:
            raise ModelError(f"joint '{name}' is a ball joint, which breaks momentum; use hinges")
        if m.dof_armature[dof] != 0.0 and kind != mujoco.mjtJoint.mjJNT_SLIDE:
            raise ModelError(
                f"joint '{name}' has armature {m.dof_armature[dof]:g}, which weakens the reaction "
                "on the bus; put the inertia into the rotor's <inertial>, armature='0'"
            )
        if j == free and _is_held(m, j):
            raise ModelError(
                f"free joint '{name}' has damping, friction or stiffness (a <default>?): nothing "
                "holds a spacecraft; use <freejoint/>"
            )
        if j in driven:
            _refuse_rotor(m, j, name)
    if np.any(m.dof_frictionloss > 0.0) and m.opt.tolerance > FRICTION_TOLERANCE:
        raise ModelError(
            f"<option tolerance='{m.opt.tolerance:g}'> with frictionloss leaks momentum; "
            f"use tolerance='1e-15' (at most {FRICTION_TOLERANCE:g})"
        )


def _is_held(m: mujoco.MjModel, free: int) -> bool:
    dofs = slice(m.jnt_dofadr[free], m.jnt_dofadr[free] + 6)
    held = m.dof_damping[dofs].any() or m.dof_frictionloss[dofs].any() or m.jnt_stiffness[free]
    return bool(held)


def _refuse_rotor(m: mujoco.MjModel, j: int, name: str) -> None:
    if m.jnt_stiffness[j] != 0.0:
        raise ModelError(
            f"wheel '{name}' has stiffness {m.jnt_stiffness[j]:g}; a rotor spins freely"
        )
    if m.jnt_limited[j]:
        raise ModelError(f"wheel '{name}' has a range; a rotor spins freely, remove it")
    body = m.jnt_bodyid[j]
    if m.body_jntnum[body] != 1:
        raise ModelError(
            f"the body of wheel '{name}' has {m.body_jntnum[body]} joints; a rotor has one"
        )
    if m.opt.timestep > IMBALANCE_TIMESTEP:
        _refuse_imbalance(m, j, name)


def _refuse_imbalance(m: mujoco.MjModel, j: int, name: str) -> None:
    """A rotor must be round about its axis, or the step short enough to see it turn."""
    body, axis = m.jnt_bodyid[j], m.jnt_axis[j]
    step = f"else <option timestep='{m.opt.timestep:g}'> must be at most {IMBALANCE_TIMESTEP:g} s"
    offset = m.body_ipos[body] - m.jnt_pos[j]
    distance = float(np.linalg.norm(offset - axis * (offset @ axis)))
    if distance > IMBALANCE_OFFSET:
        raise ModelError(
            f"wheel '{name}' is imbalanced (its centre of mass is {distance:g} m off its axis): "
            f"move it onto the axis, {step}"
        )
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, m.body_iquat[body])
    inertia = R.reshape(3, 3) * m.body_inertia[body] @ R.reshape(3, 3).T
    spin = inertia @ axis
    product = float(np.linalg.norm(spin - axis * (spin @ axis)))
    if product > IMBALANCE_PRODUCT * np.linalg.norm(spin):
        raise ModelError(
            f"wheel '{name}' is imbalanced (its axis is no principal axis of its rotor, product "
            f"of inertia {product:.2g} kg m^2): tilt the rotor's <body zaxis='...'>, not its "
            f"joint, {step}"
        )
