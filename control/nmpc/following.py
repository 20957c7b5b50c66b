"""The NMPC on a reference that moves: the same problem in the axes of the reference.

The state is the error quaternion to q_ref(t) and w_e = w - R_BT w_ref, as the paper's formulas have
it. In these axes the body feels besides what the problem knows of

    d = w_e x H_e - w x H + J_hub (w_e x w_r) - J_hub R_BT w_ref'     w_r = R_BT w_ref, H = J w + ..

which is held over the horizon as a disturbance: exact once the body is there, and below 1e-5 Nm on
the way at orbital rates.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..ground.arrays import Vector3, WheelVector
from ..ground.attitude import error_quaternion, rotation_matrix
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from ..reference.reference import Reference, mean_acceleration
from .planner import Memory, Nmpc

HALF_STEP = 0.25  # s, for the reference's angular acceleration: orbits take hours


@dataclass(frozen=True)
class FollowingNmpc:
    """An NMPC and the reference that it follows."""

    planner: Nmpc
    reference: Reference

    def plan(self, measurement: Measurement, memory: Memory | None) -> tuple[Plan, Memory | None]:
        """The torque for the coming period."""
        target = self.reference.attitude(measurement.t)
        to_body = rotation_matrix(error_quaternion(measurement.q, target)).T
        omega_r: Vector3 = to_body @ self.reference.rate(measurement.t)
        relative = replace(measurement, omega=measurement.omega - omega_r)
        planner = replace(self.planner, target=target)
        if memory is None:  # no rest is sought: the reference does not rest
            memory = Memory(np.zeros((planner.ocp.N, planner.ocp.nu)), 0)
        t = measurement.t
        turning = to_body @ mean_acceleration(self.reference, t - HALF_STEP, t + HALF_STEP)
        d = self._disturbance(measurement, relative.omega, omega_r, turning)
        return planner.plan(relative, memory, d)

    def fly_on(self, torque: WheelVector, memory: Memory | None) -> tuple[Plan, Memory | None]:
        """The previous plan without a measurement."""
        return self.planner.fly_on(torque, memory)

    def _disturbance(
        self, measurement: Measurement, omega_e: Vector3, omega_r: Vector3, turning: Vector3
    ) -> Vector3:
        """d of the equation above, Nm, body axes; `turning` is R_BT w_ref'."""
        craft = self.planner.spacecraft
        relative = np.cross(omega_e, craft.angular_momentum(omega_e, measurement.wheel_speed))
        true = np.cross(
            measurement.omega, craft.angular_momentum(measurement.omega, measurement.wheel_speed)
        )
        return relative - true + craft.J_hub @ (np.cross(omega_e, omega_r) - turning)
