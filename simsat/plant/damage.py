"""What breaks in the plant, done to MuJoCo's model and state between two ticks.

A part that locks or an inertia that changes is an inner matter of the spacecraft: the generalized
momenta p = M v on which no force acts jump by nothing, and so neither does the total momentum.
"""

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.mjcf import Model
from simsat.plant.drives import Drives

LOCKED = 1e9
"""Armature of a locked rotor over its inertia: the hub's motion turns it by 1e-9 of its own. In
relative coordinates an armature is no inertia of the body's: only the joint becomes immovable."""

FRICTION_TOLERANCE = 1e-15  # of MuJoCo's solver: friction leaks momentum at more


@dataclass(frozen=True)
class Workings:
    """The plant's insides."""

    model: Model
    m: mujoco.MjModel
    d: mujoco.MjData
    drives: Drives
    held: dict[int, float]
    """Dipoles of the rods that no longer obey, A m^2."""


Happening = Callable[[Workings], None]
"""What is done to them."""


@dataclass(frozen=True)
class Event:
    """Something that happens at the start of a tick."""

    tick: int
    happen: Happening


def weaken(wheel: int, share: float) -> Happening:
    """The motor gives this share of what is asked; none at all switches it off."""

    def happen(works: Workings) -> None:
        works.drives.weaken(wheel, share)

    return happen


def seize(wheel: int) -> Happening:
    """The rotor locks to the hub and hands over its momentum, in no time."""

    def happen(works: Workings) -> None:
        m, d, dof = works.m, works.d, works.model.wheels[wheel].dof
        M = mass_matrix(works)
        momentum = M @ d.qvel
        free = np.delete(np.arange(m.nv), dof)
        d.qvel[free] = np.linalg.solve(M[np.ix_(free, free)], momentum[free])
        d.qvel[dof] = 0.0
        m.dof_armature[dof] = LOCKED * works.model.spacecraft.Js[wheel]

    return happen


def add_friction(wheel: int, torque: float) -> Happening:
    """The bearing's Coulomb friction grows by so many Nm; a negative torque takes it back."""

    def happen(works: Workings) -> None:
        m, dof = works.m, works.model.wheels[wheel].dof
        m.dof_frictionloss[dof] = max(m.dof_frictionloss[dof] + torque, 0.0)
        m.opt.tolerance = min(m.opt.tolerance, FRICTION_TOLERANCE)

    return happen


def hold_rod(rod: int, dipole: float | None) -> Happening:
    """A magnetic rod keeps this dipole (A m^2) whatever is commanded; None lets it obey again."""

    def happen(works: Workings) -> None:
        if dipole is None:
            works.held.pop(rod, None)
        else:
            works.held[rod] = dipole

    return happen


def scale_inertia(factors: tuple[float, ...]) -> Happening:
    """The hub's principal inertias times one factor or three, as when something deploys."""

    def happen(works: Workings) -> None:
        momentum = mass_matrix(works) @ works.d.qvel
        works.m.body_inertia[works.model.bus] *= factors
        works.d.qvel[:] = np.linalg.solve(mass_matrix(works), momentum)

    return happen


def refuse_impossible(model: Model, factors: tuple[float, ...]) -> None:
    """Raises `SettingsError` where no body has such an inertia."""
    inertia = model.mj.body_inertia[model.bus] * np.array(factors)
    if not 2.0 * inertia.max() <= inertia.sum():
        row = " ".join(f"{part:.3g}" for part in inertia)
        raise SettingsError(
            f"--fault body:inertia makes the hub's principal inertias {row} kg m^2: the largest "
            "must not exceed the sum of the others"
        )


def mass_matrix(works: Workings) -> Array:
    """M(q) of the state as it is, shape (nv, nv)."""
    m, d = works.m, works.d
    mujoco.mj_fwdPosition(m, d)
    M: Array = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, M)
    return M
