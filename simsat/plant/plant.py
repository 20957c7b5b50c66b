"""The plant: MuJoCo flies the spacecraft between control instants.

Per physics step the plant enforces what the drive electronics would: the torque ramps at its rate
limit towards the commanded one, and a wheel at its speed limit gets no torque that pushes it
further. The environment's torque enters once per tick through `xfrc_applied`, evaluated at the
attitude predicted for the middle of the tick: held over 50 ms it costs below 1e-4 deg in 100 s. The
torque of magnetic rods, m x B, enters with it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternion, RodVector, Vector3, WheelVector
from simsat.control.ground.errors import DivergedError, SettingsError
from simsat.control.ground.turn import turned_floats
from simsat.mjcf import Model
from simsat.plant.damage import Event, Workings
from simsat.plant.drives import Drives
from simsat.plant.log import WINDOW, Layout, Samples, empty_log

TORQUE_BELIEVED = 1e9  # Nm; at 1e10 or nan MuJoCo switches every actuator off and flies on

ExternalTorque = Callable[[float, Quaternion], Vector3]
"""(t in s, attitude) -> torque on the spacecraft about its centre of mass, body axes, Nm."""

Field = Callable[[float], Sequence[Any]]
"""t in s -> magnetic field where the spacecraft then is, inertial axes, T, three floats."""


@dataclass(frozen=True)
class PlantState:
    """The truth at one instant."""

    t: float
    q: Quaternion
    omega: Vector3
    """Body axes, rad/s."""
    wheel_speed: WheelVector
    """Relative to the hub, rad/s."""
    torque: WheelVector
    """Motor torque acting on the rotors, Nm."""


def whole_steps(span: float, step: float, what: str) -> int:
    """How many times `step` fits into `span` exactly.

    Raises `SettingsError` naming both if they don't divide.
    """
    count = round(span / step)
    if count < 1 or not math.isclose(count * step, span, rel_tol=1e-9):
        raise SettingsError(f"{what}: {span:g} s is not a whole number of {step:g} s steps")
    return count


class Plant:
    """A spacecraft in MuJoCo, advanced tick by tick and logged.

    `tick` (s) is the interval between samples and environment updates; the physics steps are the
    model file's own `timestep` and must divide it. `ticks` is the length of the flight, of which
    the log keeps every `keep`-th sample; the last ones are at hand at the full rate (`recent`).
    `events` are what breaks in it, in order of time.
    """

    def __init__(
        self,
        model: Model,
        tick: float,
        ticks: int,
        external_torque: ExternalTorque | None = None,
        field: Field | None = None,
        keep: int = 1,
        events: Sequence[Event] = (),
    ):
        self.model = model
        self.tick = tick
        self._m = model.to_step()  # its own: the speed limit works by editing joint limits
        self._d = mujoco.MjData(self._m)
        self._qpos, self._qvel = self._d.qpos, self._d.qvel
        self._bus_torque = self._d.xfrc_applied[model.bus, 3:]
        self._steps_per_tick = whole_steps(tick, float(self._m.opt.timestep), "sample interval")
        self._external_torque = external_torque
        self._field = field
        self._rods = model.spacecraft.rods
        self._off = np.zeros(self._rods.count)
        self._commanded = self._dipole = self._off
        self._rod_torque_N = (0.0, 0.0, 0.0)
        free_qpos = int(self._m.jnt_qposadr[model.free_joint])
        free_dof = int(self._m.jnt_dofadr[model.free_joint])
        self._attitude = slice(free_qpos + 3, free_qpos + 7)
        self._rate = slice(free_dof + 3, free_dof + 6)
        self._wheel_dofs = np.array([wheel.dof for wheel in model.wheels])
        self._drives = Drives(model, self._m, self._d)
        layout = Layout(self._attitude, self._rate, self._wheel_dofs)
        sizes = (self._m.nq, self._m.nv, model.spacecraft.wheels, self._rods.count)
        self._keep = keep
        self.log = empty_log(keep * tick, ticks // keep + 1, layout, sizes)
        # With every sample kept, what is at hand is the log itself.
        self._window = self.log if keep == 1 else empty_log(tick, WINDOW, layout, sizes, True)
        self._events, self._happened = tuple(events), 0
        self._held: dict[int, float] = {}  # dipoles of rods that no longer obey, A m^2

    def reset(
        self,
        q: Quaternion,
        omega: Vector3 | None = None,
        wheel_speed: WheelVector | None = None,
    ) -> None:
        """Start at attitude q, at rest unless told otherwise; passive joints at their reference."""
        mujoco.mj_resetData(self._m, self._d)
        self._d.qpos[self._attitude] = attitude.normalized(q)
        if omega is not None:
            self._d.qvel[self._rate] = omega
        if wheel_speed is not None:
            self._d.qvel[self._wheel_dofs] = wheel_speed
        self.log.clear()
        self._window.clear()
        self._commanded = self._dipole = self._off
        self._rod_torque_N = (0.0, 0.0, 0.0)
        self._write_row()

    def advance(
        self, torque: WheelVector, ticks: int, dipole: RodVector | None = None, quiet: int = 0
    ) -> None:
        """Fly so many ticks under commanded motor torques (Nm) and dipoles of the rods (A m^2, off
        unless given), logging each.

        The rods are off for the last `quiet` ticks, and stronger before, so that the dipole is the
        mean.

        Raises `DivergedError` when the command or a rate is no longer finite; the log then ends
        before it.
        """
        if not all(abs(value) < TORQUE_BELIEVED for value in torque.tolist()):
            raise DivergedError(
                f"the simulation was stopped at t = {self.t:.2f} s: "
                f"the commanded torque {np.array2string(torque)} Nm is not finite or no wheel's"
            )
        self._commanded = self._off if dipole is None else self._possible(dipole)
        self._dipole = self._commanded * (ticks / (ticks - quiet))
        moment_B = self._moment()
        first = self.sampled
        self._drives.command(torque, ticks * self._steps_per_tick)
        for tick in range(ticks):
            if tick == ticks - quiet:
                self._dipole = self._off
                moment_B = self._moment()
            if self._let_happen():
                moment_B = self._moment()
            if self._external_torque is not None or self._rods.count:
                self._bus_torque[:] = self._mid_tick_torque(moment_B)
            self._drives.step(self._steps_per_tick)
            self._write_row()
        self._refuse_infinite(first)

    def _let_happen(self) -> bool:
        """What is due at the start of this tick; whether anything was."""
        before = self._happened
        while self._happened < len(self._events):
            event = self._events[self._happened]
            if event.tick > self.sampled - 1:
                break
            event.happen(Workings(self.model, self._m, self._d, self._drives, self._held))
            self._happened += 1
        return self._happened > before

    def _moment(self) -> Vector3 | None:
        """The rods' dipole, A m^2, body axes; None if there is none."""
        dipole = self._acting_dipole()
        return self._rods.moment(dipole) if dipole.any() else None

    def _acting_dipole(self) -> RodVector:
        """As commanded, of those that obey, and of those that don't."""
        if not self._held:
            return self._dipole
        acting = self._dipole.copy()
        for rod, dipole in self._held.items():
            acting[rod] = dipole
        return acting

    def _write_row(self) -> None:
        dipole, torque = self._acting_dipole(), self._drives.applied()
        row = (self._qpos, self._qvel, torque, dipole, self._rod_torque_N)
        self._window.append(row)
        if self._keep > 1 and (self.sampled - 1) % self._keep == 0:
            self.log.append(row)

    def _refuse_infinite(self, first: int) -> None:
        """Raise if a rate is not finite from the sample `first` on; the logs end before it."""
        held = max(first - self._window.before, 0)
        finite = np.isfinite(self._window.qvel[held : self._window.rows])
        if finite.all():
            return
        row = held + int(np.argmin(finite.all(axis=1)))
        sample = self._window.before + row
        joints = [self._m.joint(int(self._m.dof_jntid[dof])).name for dof in
                  np.flatnonzero(~finite[row - held])]  # fmt: skip
        self._window.rows = row
        self.log.rows = -(-sample // self._keep)
        raise DivergedError(
            f"the simulation diverged at t = {sample * self.tick:.2f} s: the rates of "
            f"{', '.join(dict.fromkeys(joints))} are no longer finite"
        )

    def _possible(self, dipole: RodVector) -> RodVector:
        if not np.isfinite(dipole).all():
            raise DivergedError(
                f"the simulation was stopped at t = {self.t:.2f} s: "
                f"the commanded dipole {np.array2string(dipole)} A m^2 is not finite"
            )
        if self._field is None and dipole.any():
            raise SettingsError("rods push against a magnetic field: give the plant one")
        return dipole

    def _mid_tick_torque(self, moment_B: Vector3 | None) -> tuple[float, float, float]:
        """External torque and that of the rods in world axes at the attitude predicted for the
        middle of the tick."""
        half = 0.5 * self.tick
        q_mid = turned_floats(self._qpos[self._attitude], self._qvel[self._rate] * (0.5 * half))
        t_mid = self.t + half
        torque = (0.0, 0.0, 0.0)
        if self._external_torque is not None:
            torque = _rotate(q_mid, self._external_torque(t_mid, np.array(q_mid)))
        self._rod_torque_N = (0.0, 0.0, 0.0)
        if moment_B is None:
            return torque
        assert self._field is not None
        x, y, z = self._rod_torque_N = _cross(_rotate(q_mid, moment_B), self._field(t_mid))
        return torque[0] + x, torque[1] + y, torque[2] + z

    # Questions, answered from the log.

    @property
    def sampled(self) -> int:
        """Samples so far, the start included, whether the log keeps them or not."""
        return self._window.before + self._window.rows

    @property
    def t(self) -> float:
        """Time of the newest sample, s."""
        return (self.sampled - 1) * self.tick

    def state(self, row: int = -1) -> PlantState:
        """The truth at a row of the log, or now."""
        log = self._window if row == -1 else self.log
        row = row % log.rows
        return PlantState(
            t=(log.before + row) * log.tick,
            q=log.qpos[row, self._attitude].copy(),
            omega=log.qvel[row, self._rate].copy(),
            wheel_speed=log.qvel[row, self._wheel_dofs],
            torque=log.torque[row].copy(),
        )

    @property
    def keeps_all(self) -> bool:
        """Whether the log keeps every sample."""
        return self._keep == 1

    def recent(self, count: int) -> Samples:
        """The newest samples, so many at most."""
        return self._window.samples(max(self._window.rows - count, 0))

    def since(self, row: int) -> Samples:
        """The log from a row on."""
        return self.log.samples(row)

    @property
    def attitudes(self) -> Array:
        """Body -> inertial quaternions of every sample, shape (rows, 4)."""
        return self.log.qpos[: self.log.rows, self._attitude]

    @property
    def rates(self) -> Array:
        """Body rates of every sample, body axes, rad/s, shape (rows, 3)."""
        return self.log.qvel[: self.log.rows, self._rate]

    @property
    def wheel_speeds(self) -> Array:
        """Wheel speeds of every sample relative to the hub, rad/s, shape (rows, m)."""
        return self.log.qvel[: self.log.rows, self._wheel_dofs]

    @property
    def torques(self) -> Array:
        """Motor torques acting on the rotors at every sample, Nm, shape (rows, m)."""
        return self.log.torque[: self.log.rows]

    @property
    def dipoles(self) -> Array:
        """Dipole of each rod over the tick that ended at every sample, A m^2, shape (rows, k)."""
        return self.log.dipole[: self.log.rows]

    @property
    def rod_torques_N(self) -> Array:
        """Torque of all rods over the tick that ended at every sample, inertial axes, Nm, shape
        (rows, 3)."""
        return self.log.rod_torque_N[: self.log.rows]

    @property
    def commanded_dipole(self) -> RodVector:
        """Dipole of each rod commanded over the period that ends now, A m^2, shape (k,)."""
        return self._commanded.copy()

    def field_N(self) -> Array:
        """Magnetic field at every sample, inertial axes, T, shape (rows, 3); zero without one."""
        if self._field is None:
            return np.zeros((self.log.rows, 3))
        return np.array([self._field(t) for t in self.log.t.tolist()])

    def momentum_N(self) -> Array:
        """Angular momentum about the centre of mass, inertial axes, Nms, of every sample.

        Taken from MuJoCo's own kinematics, so that panels and slosh masses count.
        """
        d = mujoco.MjData(self._m)
        momentum = np.empty((self.log.rows, 3))
        for k in range(self.log.rows):
            d.qpos[:], d.qvel[:] = self.log.qpos[k], self.log.qvel[k]
            mujoco.mj_fwdPosition(self._m, d)
            mujoco.mj_comVel(self._m, d)
            mujoco.mj_subtreeVel(self._m, d)
            momentum[k] = d.subtree_angmom[self.model.bus]
        return momentum

    def body_poses(self, first: int = 0) -> tuple[Array, Array]:
        """World positions (rows, b, 3), m, and attitudes (rows, b, 4) of every body, from the
        sample `first` on."""
        d = mujoco.MjData(self._m)
        logged = self.log.qpos[first : self.log.rows]
        positions = np.empty((len(logged), self._m.nbody, 3))
        quaternions = np.empty((len(logged), self._m.nbody, 4))
        for k, qpos in enumerate(logged):
            d.qpos[:] = qpos
            mujoco.mj_kinematics(self._m, d)
            positions[k], quaternions[k] = d.xpos, d.xquat
        return positions, quaternions


def _rotate(q: tuple[float, float, float, float], v: Vector3) -> tuple[float, float, float]:
    """R(q) v in plain floats: v + 2 w (u x v) + 2 u x (u x v)."""
    w, x, y, z = q
    a, b, c = v.tolist()
    p, r, s = y * c - z * b, z * a - x * c, x * b - y * a
    return (
        a + 2.0 * (w * p + y * s - z * r),
        b + 2.0 * (w * r + z * p - x * s),
        c + 2.0 * (w * s + x * r - y * p),
    )


def _cross(a: tuple[float, float, float], b: Sequence[float]) -> tuple[float, float, float]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
