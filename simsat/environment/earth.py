"""The Earth as the environment needs it: constants, rotation, the Sun's direction, the dipole.

Inertial frame N: equatorial, x to the mean equinox of date, z along the Earth's axis. Precession
and nutation are left out: they move nothing here by more than 0.4 degrees in 30 years.
"""

import math

import numpy as np

from simsat.control.ground.errors import SettingsError
from simsat.environment.components import Triple

MU = 3.986004418e14
"""Gravitational parameter, m^3/s^2 (IERS Conventions 2010, table 1.1)."""

RADIUS = 6378136.6
"""Equatorial radius, m (IERS Conventions 2010, table 1.1)."""

MU_SUN = 1.32712440041e20
"""Of the Sun, m^3/s^2 (IERS Conventions 2010, table 1.1)."""

AU = 149597870700.0
"""Astronomical unit, m (IAU 2012 resolution B2)."""

MAGNETOSPHERE = 10.0 * RADIUS
"""Where the Earth's field ends towards the Sun, m: the magnetopause stands at 10 to 11 radii in a
quiet solar wind (Shue et al., J. Geophys. Res. 103, 1998)."""

FLATTENING = 1.0 / 298.25642  # IERS Conventions 2010, table 1.1

ROTATION_RATE = 7.292115e-5
"""Rotation rate, rad/s (IERS Conventions 2010, table 1.2)."""

MAGNETIC_RADIUS = 6371.2e3
"""Reference radius of the geomagnetic field, m (IGRF-14)."""

DIPOLE_T: Triple = (-1410.3e-9, 4545.5e-9, -29350.0e-9)
"""Earth-fixed dipole (g11, h11, g10), T: IGRF-14 for 2025.0 (IAGA, doi 10.5281/zenodo.14012302)."""

J2000 = np.datetime64("2000-01-01T12:00:00")


def days_since_j2000(epoch_utc: str) -> float:
    """Days from 2000-01-01 12:00 to an ISO date and time (UTC taken for UT1 and TT: < 70 s)."""
    try:
        moment = np.datetime64(epoch_utc)
    except ValueError:
        moment = np.datetime64("NaT")
    if np.isnat(moment):
        raise SettingsError(
            f"orbit epoch {epoch_utc!r} isn't a date: write it as 2026-03-20T12:00:00 (UTC)"
        )
    return float((moment - J2000) / np.timedelta64(1, "s")) / 86400.0


def sidereal_angle(days: float) -> float:
    """Greenwich mean sidereal angle, rad, 0 to 2 pi (Meeus, Astronomical Algorithms, eq. 12.4)."""
    return math.radians((280.46061837 + 360.98564736629 * days) % 360.0)


def sun_direction(days: float) -> Triple:
    """Unit vector from the Earth to the Sun, inertial axes, to 0.01 degrees from 1950 to 2050.

    Low-precision series of the Astronomical Almanac (Vallado, Fundamentals of Astrodynamics and
    Applications, 4th ed., algorithm 29).
    """
    centuries = days / 36525.0
    anomaly = math.radians(357.5291092 + 35999.05034 * centuries)
    longitude = math.radians(
        280.460
        + 36000.771 * centuries
        + 1.914666471 * math.sin(anomaly)
        + 0.019994643 * math.sin(2.0 * anomaly)
    )
    obliquity = _obliquity(days)
    return (
        math.cos(longitude),
        math.cos(obliquity) * math.sin(longitude),
        math.sin(obliquity) * math.sin(longitude),
    )


def ecliptic_pole(days: float) -> Triple:
    """Unit vector at right angles to the Earth's path around the Sun, northwards."""
    obliquity = _obliquity(days)
    return 0.0, -math.sin(obliquity), math.cos(obliquity)


def _obliquity(days: float) -> float:
    """Of the ecliptic, rad (Vallado, algorithm 29)."""
    return math.radians(23.439291 - 0.0130042 * days / 36525.0)
