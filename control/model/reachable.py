"""Where a craft can rest with the momentum it has, known before the flight.

At rest the wheels hold the whole momentum H. So the axes of the wheels must span it, and their
speed limits must leave room for it: H in body axes is a point of the momentum envelope, the
zonotope {A p: |p_i| <= Js_i Omega_max_i}. With two wheels H must also lie in the plane of their
axes, n'H = 0. With a momentum h = n'H at the target the body has to spin about n there, at
s = h / n'Jn, or to cone around the target to undo the spin, at an angle of about

    rho = (2 s)^(2/3) (J / u_max)^(1/3)        (20 degrees for 1 deg/s and the paper's wheels)

Turned by asin(h / |H|) it can stand still instead. Only an external torque changes the choice.
Envelope: Markley, Reynolds, Liu and Lebsock, J. Guidance 33(5), 2010.
"""

from dataclasses import dataclass
from enum import Enum
from itertools import combinations

import numpy as np

from ..ground.arrays import Array, Quaternion, Vector3
from ..ground.attitude import from_axis_angle, multiply, rotation_matrix
from ..ground.spacecraft import RANK_TOLERANCE, Spacecraft

WIDEST_CONING = np.deg2rad(30.0)  # wider is no pointing: better a rest, however far away
FLOWN = 3.0  # times rho: at their worst both planners coned 1.6 to 3.7 rho wide (1.1 to 1.9 RMS)
AT_TARGET = np.deg2rad(0.01)  # nearer is at the target: no star tracker shows it within a minute
TINY = np.finfo(float).tiny  # Nms: stands for no momentum in a denominator


class Reach(Enum):
    """How near to the target a craft can stay; the value is a sentence."""

    TARGET = "The craft can rest at the target."
    NEAREST_REST = "The craft can rest, but not at the target."
    CONING = "The craft cannot rest near the target; it can cone around it."
    NOTHING = "The wheels cannot bring the craft to rest."


@dataclass(frozen=True)
class Reachable:
    """What can be reached, and why."""

    reach: Reach
    attitude: Quaternion | None
    """Where it can stay: the target, or the nearest attitude to rest in."""
    angle: float
    """How far from the target that is, or how far the coning leads, rad; nan for nothing."""
    reason: str
    """A sentence with the numbers that decide."""


def reachable(spacecraft: Spacecraft, target: Quaternion, H_N: Vector3) -> Reachable:
    """What a craft with momentum H_N (inertial axes, Nms) can reach of a target, by wheels alone.

    Without external torque, which would change H_N, and whatever the attitude it starts from.
    """
    if spacecraft.actuation_rank < 2:
        reason = "All wheels have one axis, and turn the craft about that alone."
        return Reachable(Reach.NOTHING, None, np.nan, reason)
    rest = nearest_rest(spacecraft, target, H_N)
    there = target if rest is None else rest
    share = envelope_share(spacecraft, rotation_matrix(there).T @ H_N)
    if share > 1.0:
        reason = (
            f"The momentum is {np.linalg.norm(H_N):.3g} Nms, {share:.3g} times what the wheels can "
            "hold in its direction before they reach their speed limits."
        )
        return Reachable(Reach.NOTHING, None, np.nan, reason)
    return _reached(spacecraft, target, H_N, rest)


def _reached(
    spacecraft: Spacecraft, target: Quaternion, H_N: Vector3, rest: Quaternion | None
) -> Reachable:
    """Of a momentum that the wheels can hold, if they span it."""
    H_T = rotation_matrix(target).T @ H_N
    along, spin = _unactuated_momentum(spacecraft, H_T)
    coning = coning_angle(spacecraft, spin)
    share = along / max(float(np.linalg.norm(H_T)), along, TINY)
    turn = float(np.arcsin(share))
    if min(turn, coning) < AT_TARGET:
        reason = "The wheels can hold the momentum at the target."
        return Reachable(Reach.TARGET, target, 0.0, reason)
    cause = (
        f"At the target {along:.3g} Nms of the momentum lie along the axis without a wheel and "
        f"turn the craft about it at {np.rad2deg(spin):.3g} deg/s"
    )
    if rest is None:
        reason = f"{cause}; undoing that takes coning, {np.rad2deg(coning):.3g} deg wide."
        return Reachable(Reach.CONING, target, coning, reason)
    reason = f"{cause}; turned by {np.rad2deg(turn):.3g} deg the wheels can hold all of it."
    return Reachable(Reach.NEAREST_REST, rest, turn, reason)


def nearest_rest(spacecraft: Spacecraft, target: Quaternion, H_N: Vector3) -> Quaternion | None:
    """The attitude nearest to the target in which the craft can rest with momentum H_N (inertial
    axes, Nms); None where staying around the target is better, or needs no choice."""
    n = spacecraft.unactuated
    H_T = rotation_matrix(target).T @ H_N
    if n is None or not np.linalg.norm(H_T) > 0.0:
        return None
    turn = float(np.arcsin(np.clip(n @ H_T / np.linalg.norm(H_T), -1.0, 1.0)))
    _, spin = _unactuated_momentum(spacecraft, H_T)
    coning = coning_angle(spacecraft, spin)
    if coning <= WIDEST_CONING and abs(turn) >= FLOWN * coning:
        return None
    across = np.cross(H_T, n)
    if np.linalg.norm(across) < 1e-6 * np.linalg.norm(H_T):
        across = np.cross(spacecraft.A[:, 0], n)  # H along n: every direction is as near
    return multiply(target, from_axis_angle(across, turn))


def coning_angle(spacecraft: Spacecraft, spin: float) -> float:
    """rho of the equation above, rad, for a spin (rad/s) about the unactuated axis."""
    inertia = float(np.trace(spacecraft.J)) / 3.0
    return float((2.0 * spin) ** (2.0 / 3.0) * (inertia / np.min(spacecraft.torque_max)) ** (1 / 3))


def envelope_share(spacecraft: Spacecraft, H_B: Vector3) -> float:
    """How much of the momentum envelope is used when the wheels hold what they can of H_B (body
    axes, Nms): 1 on its surface, 0 without speed limits."""
    size = np.abs(spacecraft.A.T @ _facets(spacecraft))
    with np.errstate(invalid="ignore"):
        room = np.where(size > RANK_TOLERANCE, size * spacecraft.momentum_max[:, None], 0.0)
    return float(np.max(np.abs(H_B @ _facets(spacecraft)) / room.sum(axis=0)))


def _facets(spacecraft: Spacecraft) -> Array:
    """Unit normals of the envelope's facets as columns: each lies across the axes of two wheels, or
    of one and the direction that none has."""
    n = spacecraft.unactuated
    axes = list(spacecraft.A.T)
    pairs = combinations(axes, 2) if n is None else ((axis, n) for axis in axes)
    normals = np.array([np.cross(a, b) for a, b in pairs])
    size = np.linalg.norm(normals, axis=1)
    kept = size > RANK_TOLERANCE
    facets: Array = (normals[kept] / size[kept, None]).T
    return facets


def _unactuated_momentum(spacecraft: Spacecraft, H_T: Vector3) -> tuple[float, float]:
    """Momentum along the axis without a wheel (Nms), and the spin that it is (rad/s); 0 where every
    axis has one."""
    n = spacecraft.unactuated
    if n is None:
        return 0.0, 0.0
    along = float(abs(n @ H_T))
    return along, along / float(n @ spacecraft.J @ n)
