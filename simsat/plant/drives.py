"""The wheels' drive electronics: torque, torque-rate and speed limits at every physics step."""

import math

import mujoco
import numpy as np

from simsat.control.ground.arrays import WheelVector
from simsat.mjcf import Drive, Model

RAMP_DONE = 1e-15  # Nm; a torque this close to its command has arrived


class Drives:
    """The motors of a model, stepping its MuJoCo data.

    The torque ramps towards the command at the drive's rate limit. A wheel at its speed limit gets
    no torque that pushes it further, and is braked back if the hub's own motion carries it past.
    """

    def __init__(self, model: Model, m: mujoco.MjModel, d: mujoco.MjData):
        self._m, self._d, self._dt = m, d, float(m.opt.timestep)
        self._act, self._ctrl = d.act, d.ctrl
        craft, wheels = model.spacecraft, model.wheels
        self._dofs = np.array([wheel.dof for wheel in wheels])
        self._joints = [wheel.joint for wheel in wheels]
        self._gain = np.array([wheel.gain for wheel in wheels])
        self._ramped = [(i, w.control, w.activation, w.gain) for i, w in enumerate(wheels)
                        if w.drive is Drive.RATE]  # fmt: skip
        self._direct = [(i, w.control) for i, w in enumerate(wheels) if w.drive is Drive.TORQUE]
        # Where each wheel's torque stands in (activations, controls).
        self._source = np.array(
            [m.na + w.control if w.activation is None else w.activation for w in wheels]
        )
        self._apart = bool(self._direct) or m.na != len(wheels)
        self._rate = craft.torque_rate_max.tolist()
        self._torque_max = craft.torque_max
        self._speed_max = craft.speed_max
        # Rotor acceleration per Nm, relative to the hub, which moves the other way.
        self._agility = 1.0 / craft.Js + np.einsum(
            "im,ij,jm->m", craft.A, np.linalg.inv(craft.J_hub), craft.A
        )
        self._reach = list(
            zip(
                craft.speed_max.tolist(),
                craft.torque_max.tolist(),
                self._agility.tolist(),
                strict=True,
            )
        )
        self._targets: list[float] = [0.0] * craft.wheels
        self._shares = [1.0] * craft.wheels  # of the torque asked that a motor gives
        self._asked, self._steps = np.zeros(craft.wheels), 0
        self._moving = True
        self._clamped = False
        self._file_clamp = (m.jnt_actfrclimited.copy(), m.jnt_actfrcrange.copy())

    def command(self, torque: WheelVector, steps: int) -> None:
        """Aim for these torques (Nm, clipped to their limits) over the next so many steps."""
        # np.clip and array arithmetic would cost as much as a physics step
        self._asked, self._steps = torque, steps
        limits = self._torque_max.tolist()
        self._targets = [
            share * max(-limit, min(limit, asked))
            for asked, limit, share in zip(torque.tolist(), limits, self._shares, strict=True)
        ]
        self._moving = bool(self._ramped)
        for i, actuator in self._direct:
            self._ctrl[actuator] = self._targets[i] / self._gain[i]
        near = self._near_speed_limit(steps)
        if self._clamped and not near:
            self._m.jnt_actfrclimited[:], self._m.jnt_actfrcrange[:] = self._file_clamp
        self._clamped = near

    def weaken(self, wheel: int, share: float) -> None:
        """Let a motor give this share of what is asked from now on; at zero its current is cut."""
        self._shares[wheel] = share
        if share == 0.0:
            for i, _, activation, _ in self._ramped:
                if i == wheel:
                    self._act[activation] = 0.0
        self.command(self._asked, self._steps)

    def step(self, steps: int) -> None:
        """Step the physics so many times."""
        while steps > 0:
            held = self._ramp(steps) if self._moving else steps
            if self._clamped:
                held = 1
                self._clamp_to_speed_limit()
            mujoco.mj_step(self._m, self._d, nstep=held)
            steps -= held

    def applied(self) -> WheelVector:
        """Torque on the rotors now, Nm: what the drives give, less what the speed limit takes."""
        if self._apart:
            drive = np.concatenate((self._act, self._ctrl))[self._source] * self._gain
        else:  # the common case, and the plant's inner loop: activations are in wheel order
            drive = self._act * self._gain
        return np.clip(drive, *self._speed_bounds()) if self._clamped else drive

    def _ramp(self, steps: int) -> int:
        """Set the torque rates; returns for how many of the next steps they may stay."""
        self._moving = False
        for i, actuator, activation, gain in self._ramped:
            missing = self._targets[i] - gain * self._act[activation]
            whole = int(abs(missing) / (self._rate[i] * self._dt))
            if whole > 0:
                rate = math.copysign(self._rate[i], missing)
                steps = min(steps, whole)
            elif abs(missing) > RAMP_DONE:
                rate = missing / self._dt
                steps = 1
            else:
                rate = 0.0
            self._ctrl[actuator] = rate / gain
            self._moving = self._moving or rate != 0.0
        return steps

    def _near_speed_limit(self, steps: int) -> bool:
        """Whether any wheel could reach its limit within so many steps (twice over, for safety)."""
        span = 2.0 * self._dt * steps
        speeds = self._d.qvel[self._dofs].tolist()
        for (limit, strongest, agility), speed, target in zip(
            self._reach, speeds, self._targets, strict=True
        ):
            torque = strongest if strongest < math.inf else abs(target)
            if abs(speed) + span * agility * torque >= limit:
                return True
        return False

    def _speed_bounds(self) -> tuple[WheelVector, WheelVector]:
        """Lowest and highest torque under which no wheel passes its speed limit in one step."""
        speed = self._d.qvel[self._dofs]
        scale = 1.0 / (self._agility * self._dt)
        low, high = (-self._speed_max - speed) * scale, (self._speed_max - speed) * scale
        limit = self._torque_max
        return np.clip(low, -limit, limit), np.clip(high, -limit, limit)

    def _clamp_to_speed_limit(self) -> None:
        for joint, low, high in zip(self._joints, *self._speed_bounds(), strict=True):
            if math.isfinite(low) and math.isfinite(high):
                self._m.jnt_actfrclimited[joint] = 1
                self._m.jnt_actfrcrange[joint] = low, high
