"""A rotor: everything that turns rigidly with a wheel's hinge, and how far it is out of balance."""

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from simsat.control.ground.arrays import Array, Matrix3, Vector3


@dataclass(frozen=True)
class Rotor:
    """What turns with a hinge: the joint's body and all that is fixed to it, in its axes."""

    joint: int
    bodies: frozenset[int]
    mass: float
    axis: Vector3
    """Unit vector of the hinge."""
    offset: Vector3
    """From the hinge to the centre of mass, across the axis, m."""
    inertia: Matrix3
    """About the centre of mass, kg m^2."""

    @property
    def spin_inertia(self) -> float:
        """Moment of inertia about the hinge, kg m^2."""
        return float(self.axis @ self.inertia @ self.axis + self.mass * self.offset @ self.offset)

    @property
    def eccentricity(self) -> float:
        """Static imbalance: the centre of mass's distance from the hinge, over the radius of
        gyration about it. 1e-4 is a reaction wheel, 1 a body hinged at its end."""
        return float(np.linalg.norm(self.offset) / np.sqrt(self.spin_inertia / self.mass))

    @property
    def product(self) -> float:
        """Product of inertia about the axis, kg m^2: zero where the axis is a principal one."""
        spin = self.inertia @ self.axis
        return float(np.linalg.norm(spin - self.axis * (self.axis @ spin)))

    @property
    def wobble(self) -> float:
        """Dynamic imbalance: the product of inertia over the spin inertia."""
        return self.product / self.spin_inertia

    @property
    def flatness(self) -> float:
        """Difference of the moments of inertia across the axis over the spin inertia: 0 is round,
        1 a sheet that turns about a line in it."""
        across = np.linalg.svd(self.axis[None])[2][1:]
        least, most = np.linalg.eigvalsh(across @ self.inertia @ across.T)
        return float(most - least) / self.spin_inertia

    @property
    def imbalance(self) -> float:
        """The worst of the three: how far J moves as the rotor turns, in spin inertias."""
        return max(self.eccentricity, self.wobble, self.flatness)


def read_rotor(m: mujoco.MjModel, joint: int) -> Rotor:
    """What turns with a hinge joint."""
    root = int(m.jnt_bodyid[joint])
    masses, places, inertias, bodies = [], [], [], []
    for body, pos, R in _fixed_to(m, root, np.array([0.0, 0.0, 0.0]), np.eye(3)):
        R_own = R @ _matrix(m.body_iquat[body])
        bodies.append(body)
        masses.append(float(m.body_mass[body]))
        places.append(pos + R @ m.body_ipos[body])
        inertias.append(R_own * m.body_inertia[body] @ R_own.T)
    mass = sum(masses)
    centre = np.average(places, axis=0, weights=masses) if mass > 0.0 else places[0]
    inertia = sum(
        own + part * ((p - centre) @ (p - centre) * np.eye(3) - np.outer(p - centre, p - centre))
        for own, part, p in zip(inertias, masses, places, strict=True)
    )
    axis = m.jnt_axis[joint].copy()
    arm = centre - m.jnt_pos[joint]
    offset = arm - axis * (axis @ arm)
    return Rotor(joint, frozenset(bodies), mass, axis, offset, np.asarray(inertia))


def subtree(m: mujoco.MjModel, root: int) -> frozenset[int]:
    """A body and everything that hangs on it."""
    inside = {root}
    for body in range(root + 1, m.nbody):  # parents come first
        if int(m.body_parentid[body]) in inside:
            inside.add(body)
    return frozenset(inside)


def _fixed_to(
    m: mujoco.MjModel, body: int, pos: Vector3, R: Matrix3
) -> Iterator[tuple[int, Vector3, Matrix3]]:
    """A body at a place, and those fixed to it without a joint, each with its own place."""
    yield body, pos, R
    for child in range(body + 1, m.nbody):
        if m.body_parentid[child] == body and m.body_jntnum[child] == 0:
            there = R @ _matrix(m.body_quat[child])
            yield from _fixed_to(m, child, pos + R @ m.body_pos[child], there)


def _matrix(q: Array) -> Matrix3:
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, q)
    return R.reshape(3, 3)
