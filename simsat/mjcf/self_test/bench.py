"""A model on the test bench: kicked, stepped, and its momenta read off MuJoCo's own kinematics."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Matrix3, Vector3, WheelVector
from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf.rotors import Rotor
from simsat.mjcf.wheels import Drive, WheelDrive

ATTITUDE = attitude.from_axis_angle(np.array([0.3, -0.5, 0.8]), 1.1)  # about no axis in particular


@dataclass(frozen=True)
class Motion:
    """Momenta at one instant."""

    H_N: Vector3
    """About the centre of mass, from MuJoCo's body velocities, Nms."""
    P_N: Vector3
    """Linear momentum, kg m/s."""
    H_read: Vector3
    """J w + A (Js * Omega) with the numbers that were read, inertial axes, Nms."""
    spin: WheelVector
    """Js (Omega + A'w) of each rotor, Nms."""
    angle: WheelVector
    """Of each wheel against the bus, rad."""
    size: float
    """Sum of the sizes of all parts of the angular momentum, Nms."""
    push: float
    """The same of the linear momentum, kg m/s."""
    swing: float
    """The passive joints' share of `size`, and at least of `push` times the radius of gyration."""


class Bench:
    """A model as the plant steps it (`stepped`), with MuJoCo data of its own."""

    def __init__(
        self,
        m: mujoco.MjModel,
        free: int,
        wheels: Sequence[WheelDrive],
        rotors: Sequence[Rotor],
        craft: Spacecraft,
    ):
        self.m, self.d, self.wheels, self.craft = m, mujoco.MjData(m), wheels, craft
        self.bus = int(m.jnt_bodyid[free])
        first = int(m.jnt_dofadr[free])
        self.linear, self.turning = slice(first, first + 3), slice(first + 3, first + 6)
        self.dofs = np.array([wheel.dof for wheel in wheels])
        self.passive = np.setdiff1d(np.arange(m.nv), [*range(first, first + 6), *self.dofs])
        self.gyration = math.sqrt(np.trace(craft.J) / craft.mass)
        self._angles = np.array([wheel.qpos for wheel in wheels])
        q = int(m.jnt_qposadr[free]) + 3
        self._attitude = slice(q, q + 4)
        self.start(np.zeros(m.nv))
        momenta = np.stack([self._momentum_of(k) for k in range(m.nv)], axis=1)
        self.columns, self._pushes = momenta[:3], np.linalg.norm(momenta[3:], axis=0)
        """Angular momentum of a unit rate of each degree of freedom, body axes, shape (3, nv)."""
        self.shake = np.array([self._shake(rotor) for rotor in rotors])
        """How much momentum each turning rotor has across its axis, or moves J by, over its own."""

    def start(self, rates: Array) -> None:
        """At the reference, turned to a general attitude, with these rates; motors off."""
        mujoco.mj_resetData(self.m, self.d)
        self.d.qpos[self._attitude] = ATTITUDE
        self.d.qvel[:] = rates
        mujoco.mj_fwdPosition(self.m, self.d)

    def command(self, torque: WheelVector, time: float) -> None:
        """Motor torques (Nm) that are held, or that a ramp reaches after `time` (s)."""
        for wheel, most in zip(self.wheels, torque.tolist(), strict=True):
            ramp = time if wheel.drive is Drive.RATE else 1.0
            self.d.ctrl[wheel.control] = most / wheel.gain / ramp

    def force_of(self, torque: WheelVector) -> Array:
        """Generalized forces of the motors when they give these torques (Nm), shape (nv,)."""
        self.start(np.zeros(self.m.nv))
        for wheel, given in zip(self.wheels, torque.tolist(), strict=True):
            if wheel.activation is None:
                self.d.ctrl[wheel.control] = given / wheel.gain
            else:
                self.d.act[wheel.activation] = given / wheel.gain
        mujoco.mj_forward(self.m, self.d)
        return self.d.qfrc_actuator.copy()

    def step(self) -> WheelVector:
        """One step; the impulse of each motor over it, Nms: its torque is linear in a step."""
        before = self._torque()
        mujoco.mj_step(self.m, self.d)
        impulse: WheelVector = 0.5 * self.m.opt.timestep * (before + self._torque())
        return impulse

    def breakdown(self) -> str:
        """What MuJoCo warned of since the start, or that it left the finite numbers; else ''."""
        for kind, warning in enumerate(self.d.warning):
            if warning.number:
                return mujoco.mju_warningText(kind, warning.lastinfo)
        return "" if np.isfinite(self.d.qvel).all() else "a rate is not finite"

    def motion(self) -> Motion:
        """Its momenta now."""
        m, d, craft = self.m, self.d, self.craft
        mujoco.mj_fwdPosition(m, d)
        mujoco.mj_comVel(m, d)
        mujoco.mj_subtreeVel(m, d)
        omega, speed = d.qvel[self.turning], d.qvel[self.dofs]
        turns = np.linalg.norm(self.columns, axis=0) * np.abs(d.qvel)
        pushes = self._pushes * np.abs(d.qvel)
        swing = np.maximum(turns, pushes * self.gyration)[self.passive]
        return Motion(
            H_N=d.subtree_angmom[self.bus].copy(),
            P_N=craft.mass * d.subtree_linvel[self.bus],
            H_read=self._R() @ craft.angular_momentum(omega, speed),
            spin=craft.Js * (speed + omega @ craft.A),
            angle=d.qpos[self._angles].copy(),
            size=float(turns.sum()),
            push=float(pushes.sum() + turns.sum() / self.gyration),
            swing=float(swing.sum()),
        )

    def _torque(self) -> WheelVector:
        """What the motors give now, Nm."""
        d = self.d
        return np.array(
            [
                w.gain * (d.ctrl[w.control] if w.activation is None else d.act[w.activation])
                for w in self.wheels
            ]
        )

    def _momentum_of(self, dof: int) -> Array:
        """(angular in body axes, linear) of a unit rate, shape (6,)."""
        self.d.qvel[dof] = 1.0
        mujoco.mj_comVel(self.m, self.d)
        mujoco.mj_subtreeVel(self.m, self.d)
        self.d.qvel[dof] = 0.0
        angular = self._R().T @ self.d.subtree_angmom[self.bus]
        return np.concatenate([angular, self.craft.mass * self.d.subtree_linvel[self.bus]])

    def _shake(self, rotor: Rotor) -> float:
        off = float(np.linalg.norm(rotor.offset))
        centre = self.d.subtree_com[int(self.m.jnt_bodyid[rotor.joint])]
        arm = float(np.linalg.norm(centre - self.d.subtree_com[self.bus])) + off
        return rotor.wobble + rotor.flatness + rotor.mass * off * arm / rotor.spin_inertia

    def _R(self) -> Matrix3:
        return attitude.rotation_matrix(self.d.qpos[self._attitude])
