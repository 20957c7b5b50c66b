"""The wheels' drive electronics: limits of torque, torque rate and speed at every physics step."""

import math

import mujoco
import numpy as np

from simsat.control.ground.arrays import WheelVector
from simsat.mjcf import Drive, Model

RAMP_DONE = 2.5e-13  # of what a ramp covers in a step: a torque this close has arrived


class Drives:
    """The motors of a model, stepping its MuJoCo data.

    The torque ramps towards the command at the drive's rate limit. A wheel at its speed limit gets
    no torque that pushes it further, and is braked back if the hub's own motion carries it past.
    Where a motor has a torque-speed envelope, it drives with what is available in the middle of
    each step, and its torque has to ramp again from there.
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
        self._envelopes = [(i, e) for i, e in enumerate(craft.envelopes) if e is not None]
        self._weakened = [r for r in self._ramped if r[0] in dict(self._envelopes)]
        full = craft.speed_max.copy()  # up to which a wheel has its full torque
        for i, envelope in self._envelopes:
            full[i] = min(full[i], envelope.knee)
        self._reach = list(
            zip(
                full.tolist(),
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
        near = self._near_limit(steps)
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
            if self._clamped:
                self._unwind()
            held = self._ramp(steps) if self._moving else steps
            if self._clamped:
                held = 1
                self._clamp()
            mujoco.mj_step(self._m, self._d, nstep=held)
            steps -= held

    def applied(self) -> WheelVector:
        """Torque on the rotors now, Nm: what the drives give, less what speed takes."""
        if self._apart:
            drive = np.concatenate((self._act, self._ctrl))[self._source] * self._gain
        else:  # the common case, and the plant's inner loop: activations are in wheel order
            drive = self._act * self._gain
        return np.clip(drive, *self._bounds()) if self._clamped else drive

    def _ramp(self, steps: int) -> int:
        """Set the torque rates; returns for how many of the next steps they may stay."""
        self._moving = False
        for i, actuator, activation, gain in self._ramped:
            missing = self._targets[i] - gain * self._act[activation]
            whole = int(abs(missing) / (self._rate[i] * self._dt))
            if whole > 0:
                rate = math.copysign(self._rate[i], missing)
                steps = min(steps, whole)
            elif abs(missing) > RAMP_DONE * self._rate[i] * self._dt:
                rate = missing / self._dt
                steps = 1
            else:
                rate = 0.0
            self._ctrl[actuator] = rate / gain
            self._moving = self._moving or rate != 0.0
        return steps

    def _near_limit(self, steps: int) -> bool:
        """Whether any wheel could reach its speed limit, or a speed at which its motor is weaker,
        within so many steps (twice over, for safety)."""
        span = 2.0 * self._dt * steps
        speeds = self._d.qvel[self._dofs].tolist()
        for (limit, strongest, agility), speed, target in zip(
            self._reach, speeds, self._targets, strict=True
        ):
            torque = strongest if strongest < math.inf else abs(target)
            if abs(speed) + span * agility * torque >= limit:
                return True
        return False

    def _bounds(self) -> tuple[WheelVector, WheelVector]:
        """Lowest and highest torque that the motors give for one step: within their envelopes, and
        so that no wheel passes its speed limit."""
        speed = self._d.qvel[self._dofs]
        scale = 1.0 / (self._agility * self._dt)
        low, high = (-self._speed_max - speed) * scale, (self._speed_max - speed) * scale
        weakest, strongest = -self._torque_max, self._torque_max.copy()
        for i, envelope in self._envelopes:
            driven = envelope.held(abs(speed[i]), 0.5 * self._dt * self._agility[i])
            if speed[i] >= 0.0:
                strongest[i] = min(strongest[i], driven)
            else:
                weakest[i] = max(weakest[i], -driven)
        return np.clip(low, weakest, strongest), np.clip(high, weakest, strongest)

    def _unwind(self) -> None:
        """Torques that their envelopes have cut ramp from what is left, not from what was asked."""
        if self._weakened:
            low, high = self._bounds()
            for i, _, activation, gain in self._weakened:
                given = min(max(gain * self._act[activation], low[i]), high[i])
                self._act[activation] = given / gain
            self._moving = True

    def _clamp(self) -> None:
        for joint, low, high in zip(self._joints, *self._bounds(), strict=True):
            if math.isfinite(low) and math.isfinite(high):
                self._m.jnt_actfrclimited[joint] = 1
                self._m.jnt_actfrcrange[joint] = low, high
