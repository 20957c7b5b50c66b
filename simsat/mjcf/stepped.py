"""The model that MuJoCo steps: a copy of the file's, solved as momentum asks, unused motors off."""

import copy
from collections.abc import Collection

import mujoco


def to_step(m: mujoco.MjModel, unused: Collection[int]) -> mujoco.MjModel:
    """A copy in which the actuators of these indices give no force, whatever their kind.

    Dry friction is a constraint. Newton and CG iterate on accelerations, and what they leave over
    acts like an external torque (4e-10 Nm on a sticking wheel at tolerance 1e-15); PGS iterates on
    forces, from which the accelerations follow: momentum is exact.
    """
    m = copy.deepcopy(m)
    m.opt.solver = mujoco.mjtSolver.mjSOL_PGS
    if unused:
        taken = {int(m.actuator_group[i]) for i in range(m.nactuator) if i not in unused}
        group = next(g for g in range(len(taken) + 1) if g not in taken)
        m.actuator_group[list(unused)] = group
        m.opt.disableactuator = 1 << group
    return m
