"""From the frame of J2000 to this project's inertial one, which is of date."""

import math

import numpy as np

from simsat.control.ground.arrays import Quaternion
from simsat.control.ground.attitude import from_axis_angle, multiply

ARCSECOND = math.radians(1.0 / 3600.0)
Z, Y = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


def j2000_in_date(days: float) -> Quaternion:
    """Attitude of the axes of J2000 (EME2000, ICRF) in the mean equator and equinox of date, so
    many days from J2000: v_date = R(q) v_J2000.

    IAU 1976 precession, 0.36 degrees by 2026; nutation (17 arcseconds) is left out. Source: Meeus,
    Astronomical Algorithms, eq. 21.3.
    """
    T = days / 36525.0
    zeta = (2306.2181 * T + 0.30188 * T**2 + 0.017998 * T**3) * ARCSECOND
    z = (2306.2181 * T + 1.09468 * T**2 + 0.018203 * T**3) * ARCSECOND
    theta = (2004.3109 * T - 0.42665 * T**2 - 0.041833 * T**3) * ARCSECOND
    # v_date = Rz(z) Ry(-theta) Rz(zeta) v_J2000, R turning vectors
    return multiply(
        multiply(from_axis_angle(Z, z), from_axis_angle(Y, -theta)), from_axis_angle(Z, zeta)
    )
