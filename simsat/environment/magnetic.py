"""Torque of the spacecraft's residual magnetic dipole in the Earth's field."""

from simsat.control.ground.arrays import Vector3
from simsat.environment.components import (
    Triple,
    added,
    applied,
    cos_sin,
    cross,
    dot,
    scaled,
    triple,
)
from simsat.environment.earth import (
    DIPOLE_T,
    MAGNETIC_RADIUS,
    ROTATION_RATE,
    sidereal_angle,
)
from simsat.environment.orbit import Orbit
from simsat.environment.scene import Scene, TorqueModel


def magnetic(dipole_B: Vector3, orbit: Orbit) -> TorqueModel:
    """tau_B = m x B, m the residual dipole (A m^2, body axes), B the Earth's dipole field.

    Source: Wertz, Spacecraft Attitude Determination and Control, eq. 17-68.
    """
    m_B = triple(dipole_B)

    def torque(scene: Scene) -> Triple:
        return cross(m_B, applied(scene.to_body, field(scene, orbit)))

    return torque


def field(scene: Scene, orbit: Orbit) -> Triple:
    """B = (a/R)^3 [3 (g . r) r - g], T, inertial axes: the tilted dipole that turns with the Earth.

    The higher orders of the real field, up to 30 % near Brazil, are left out. Source: Wertz,
    Spacecraft Attitude Determination and Control, eq. H-16; coefficients of IGRF-14.
    """
    c, s = cos_sin(sidereal_angle(orbit.epoch_days) + ROTATION_RATE * scene.t)
    x, y, z = DIPOLE_T
    g_N = (c * x - s * y, s * x + c * y, z)
    upward = scaled(3.0 * dot(g_N, scene.up_N), scene.up_N)
    return scaled((MAGNETIC_RADIUS / orbit.radius) ** 3, added(upward, scaled(-1.0, g_N)))
