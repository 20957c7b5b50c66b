"""What is left of a spacecraft without its rotors: the bus that an MJCF file asks for.

Mass tables and data sheets speak of the whole spacecraft, J of the whole with its rotors locked; a
file has the rotors as bodies of their own. With S(r) = (r.r) 1 - r r', d_i the place of rotor i
from the whole's centre of mass and I_i its inertia about its own,

    m_bus = m - sum m_i
    d_bus = -sum m_i d_i / m_bus
    J_bus = J - sum (I_i + m_i S(d_i)) - m_bus S(d_bus)

(parallel axes: Wertz, Spacecraft Attitude Determination and Control, section 16.1).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from simsat.control.ground.arrays import Matrix3, Vector3
from simsat.control.ground.errors import ModelError

ROUND_OFF = 1e-12  # of the largest moment


@dataclass(frozen=True)
class Body:
    """A rigid body's mass, kg, its centre of mass from the origin, m, and its inertia about that,
    kg m^2, all in the spacecraft's axes."""

    mass: float
    centre: Vector3
    inertia: Matrix3


def spread(r: Vector3) -> Matrix3:
    """S(r) = (r.r) 1 - r r': the inertia of a unit mass at r, m^2."""
    matrix: Matrix3 = r @ r * np.eye(3) - np.outer(r, r)
    return matrix


def joined(bodies: Sequence[Body]) -> Body:
    """Several bodies, fixed to each other, as one."""
    mass = sum(body.mass for body in bodies)
    moments = [body.mass * body.centre for body in bodies]
    centre: Vector3 = np.sum(moments, axis=0) / mass
    inertia = [body.inertia + body.mass * spread(body.centre - centre) for body in bodies]
    return Body(mass, centre, np.sum(inertia, axis=0))


def without(whole: Body, rotors: Iterable[Body]) -> Body:
    """The whole less its rotors.

    Raises `ModelError` if nothing that exists is left.
    """
    mass, moment, inertia = whole.mass, np.zeros(3), whole.inertia.copy()
    for rotor in rotors:
        d = rotor.centre - whole.centre
        mass -= rotor.mass
        moment -= rotor.mass * d
        inertia -= rotor.inertia + rotor.mass * spread(d)
    if not mass > 0.0:
        raise ModelError(
            f"the rotors weigh {whole.mass - mass:g} kg, the whole spacecraft {whole.mass:g} kg; "
            "the bus must weigh something, state the mass of the whole with its rotors"
        )
    d_bus: Vector3 = moment / mass
    bus = Body(mass, whole.centre + d_bus, inertia - mass * spread(d_bus))
    refuse_impossible(bus.inertia, "the bus, the whole without its rotors,")
    return bus


def refuse_impossible(inertia: Matrix3, whose: str) -> None:
    """Raise `ModelError` if no body has this inertia: its principal moments must be above zero, and
    none exceed the sum of the others."""
    if not np.allclose(inertia, inertia.T, rtol=1e-9, atol=0.0):
        raise ModelError(f"the inertia of {whose} is not symmetric; give I_xy = I_yx and so on")
    moments = np.linalg.eigvalsh(inertia)
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    if not moments[0] > 0.0:
        raise ModelError(
            f"{whose} would have the principal moments {shown} kg m^2, which must be above zero: "
            "the inertia is too small for what it holds"
        )
    if not moments[2] <= moments[0] + moments[1] + ROUND_OFF * moments[2]:
        raise ModelError(
            f"{whose} would have the principal moments {shown} kg m^2, but no body's largest "
            "exceeds the sum of the others: check signs of the products and units"
        )
