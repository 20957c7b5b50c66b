"""Density of the upper atmosphere along the orbit."""

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.environment import earth
from simsat.environment.components import Number
from simsat.environment.orbit import CircularOrbit, Orbit

Density: TypeAlias = Callable[[Number], Number]
"""Density at time t (s), kg/m^3."""

# Base altitude km, density kg/m^3, scale height km: US Standard Atmosphere 1976 below, CIRA-72
# above 500 km (Vallado, Fundamentals of Astrodynamics and Applications, 4th ed., table 8-4).
EXPONENTIAL_BANDS = (
    (150.0, 2.070e-9, 22.523),
    (180.0, 5.464e-10, 29.740),
    (200.0, 2.789e-10, 37.105),
    (250.0, 7.248e-11, 45.546),
    (300.0, 2.418e-11, 53.628),
    (350.0, 9.518e-12, 53.298),
    (400.0, 3.725e-12, 58.515),
    (450.0, 1.585e-12, 60.828),
    (500.0, 6.967e-13, 63.822),
    (600.0, 1.454e-13, 71.835),
    (700.0, 3.614e-14, 88.667),
    (800.0, 1.170e-14, 124.64),
    (900.0, 5.245e-15, 181.05),
    (1000.0, 3.019e-15, 268.00),
)

TABLE_STEP_S = 60.0  # NRLMSIS changes by up to 7 % a minute at 500 km
TABLE_SPAN_S = 86400.0


def exponential_density(altitude_km: float) -> float:
    """Density at an altitude, kg/m^3: rho0 exp(-(h - h0) / H) of the band that holds it."""
    base, rho, height = next(
        (band for band in reversed(EXPONENTIAL_BANDS) if band[0] <= altitude_km),
        EXPONENTIAL_BANDS[0],
    )
    return rho * math.exp(-(altitude_km - base) / height)


def density_of_altitude(orbit: Orbit) -> Density:
    """The exponential model along the orbit: one number on a circular one."""
    if isinstance(orbit, CircularOrbit):
        rho = exponential_density((orbit.radius - earth.RADIUS) / 1e3)
        return lambda t: rho

    def at(t: Number) -> Number:
        altitude_km = (orbit.radius_at(t) - earth.RADIUS) / 1e3
        if isinstance(altitude_km, float):
            return exponential_density(altitude_km)
        return np.array([exponential_density(h) for h in altitude_km.tolist()])

    return at


def nrlmsis_density(orbit: Orbit, f107: float, f107a: float, ap: float) -> Density:
    """NRLMSIS 2.1 along the orbit, for fixed solar and geomagnetic indices.

    Tabulated once a minute for a day and interpolated linearly (0.1 %); after a day the table
    starts over. Source: Emmert et al., Space Weather 20 (2022), through `pymsis`.
    """
    t = np.arange(0.0, TABLE_SPAN_S + TABLE_STEP_S, TABLE_STEP_S)
    table = _nrlmsis(t, orbit, f107, f107a, ap)
    last = len(table) - 1
    values = [float(rho) for rho in table]

    def at(t: Number) -> Number:
        if not isinstance(t, float):
            return np.interp(np.mod(t, TABLE_SPAN_S), np.arange(last + 1) * TABLE_STEP_S, table)
        cell, fraction = divmod(t % TABLE_SPAN_S / TABLE_STEP_S, 1.0)
        i = int(cell)
        return values[i] + fraction * (values[i + 1] - values[i])

    return at


def _nrlmsis(t: Array, orbit: Orbit, f107: float, f107a: float, ap: float) -> Array:
    import pymsis  # only this model needs it, and loading it costs 0.1 s

    longitude_deg, latitude_deg, altitude_km = geodetic(t, orbit)
    when = earth.J2000 + np.array((orbit.epoch_days * 86400.0 + t) * 1e3, dtype="timedelta64[ms]")
    index = np.ones(len(t))
    result = pymsis.calculate(
        when,
        longitude_deg,
        latitude_deg,
        altitude_km,
        f107s=f107 * index,
        f107as=f107a * index,
        aps=np.full((len(t), 7), ap),
        version=2.1,
    )
    return np.asarray(result, float)[:, pymsis.Variable.MASS_DENSITY]


def geodetic(t: Array, orbit: Orbit) -> tuple[Array, Array, Array]:
    """Longitude (deg, 0 to 360), geodetic latitude (deg) and altitude (km) along the orbit.

    First order in the flattening: 50 m of altitude, 0.01 degrees of latitude.
    """
    x, y, z = (np.asarray(component, float) for component in orbit.direction(t))
    turn = earth.sidereal_angle(orbit.epoch_days) + earth.ROTATION_RATE * t
    geocentric = np.arcsin(z)
    latitude = geocentric + earth.FLATTENING * np.sin(2.0 * geocentric)
    altitude = orbit.radius_at(t) - earth.RADIUS * (1.0 - earth.FLATTENING * z**2)
    return (
        np.rad2deg(np.arctan2(y, x) - turn) % 360.0,
        np.rad2deg(latitude),
        altitude / 1e3,
    )
