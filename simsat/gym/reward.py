"""What an agent is paid: minus the cost that `nmpc` minimises, of the state it reached.

    reward = -(|phi|_W^2 + w |omega|^2 + e |a|^2 + d |a - a_before|^2),   phi = 2 q_v

in the craft's own units, with the weights of `--nmpc.weights` and torques a as shares of their
limits (`control/nmpc/cost`). The return of an episode is so what it cost, and comparable with the
planner's. It is bounded: -4 at most for the attitude with three wheels, -80 with two, where the
axis without a wheel weighs 20.
"""

import numpy as np

from simsat.control.ground.arrays import Quaternion, Vector3, WheelVector
from simsat.control.nmpc.cost import Weights


def reward(
    q_BT: Quaternion,
    omega: Vector3,
    share: WheelVector,
    before: WheelVector,
    weights: Weights,
    loop_normal: Vector3 | None,
) -> float:
    """The equation above; omega in rad per own second, `loop_normal` is the spacecraft's, None if
    no axis is unactuated."""
    phi = 2.0 * q_BT[1:]
    along = 0.0 if loop_normal is None else float(loop_normal @ phi)
    cost = (
        weights.attitude * float(phi @ phi - along**2)
        + (weights.attitude if loop_normal is None else weights.unactuated) * along**2
        + weights.rate * float(omega @ omega)
        + weights.effort * float(share @ share)
        + weights.increment * float(np.sum((share - before) ** 2))
    )
    return -cost
