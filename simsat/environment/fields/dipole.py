"""The Earth's field as a tilted dipole that turns with it."""

from simsat.environment.components import Number, Triple, added, cos_sin, dot, scaled
from simsat.environment.earth import DIPOLE_T, MAGNETIC_RADIUS, ROTATION_RATE, sidereal_angle
from simsat.environment.fields.field import MagneticField
from simsat.environment.orbit import Orbit


def dipole_field(orbit: Orbit) -> MagneticField:
    """B = (a/R)^3 [3 (g . r) r - g], T, inertial axes.

    The higher orders of the real field, 23 % in the mean at 500 km and 71 % at most, are left out.
    Source: Wertz, Spacecraft Attitude Determination and Control, eq. H-16; coefficients of IGRF-14.
    """

    def at(t: Number) -> Triple:
        c, s = cos_sin(sidereal_angle(orbit.epoch_days) + ROTATION_RATE * t)
        x, y, z = DIPOLE_T
        g_N = (c * x - s * y, s * x + c * y, z)
        up_N = orbit.direction(t)
        upward = scaled(3.0 * dot(g_N, up_N), up_N)
        return scaled((MAGNETIC_RADIUS / orbit.radius_at(t)) ** 3, added(upward, scaled(-1.0, g_N)))

    return at
