"""The Earth's main field as geophysics has it: IGRF-14, 13 orders of spherical harmonics."""

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.environment import earth
from simsat.environment.fields.field import MagneticField
from simsat.environment.orbit import Orbit
from simsat.environment.table import Table

STEP_S = 30.0
"""Between samples along the orbit: cubic between them is within 0.2 nT of the series (20,000 to
50,000) in 500 km."""
FIRST, LAST = (
    "1900-01-01",
    "2030-01-01",
)  # what the coefficients cover
TESLA = 1e-9  # per nT
OFF_POLE = 1e-9  # of the radius: at the pole itself east has no direction


def igrf_field(orbit: Orbit) -> MagneticField:
    """IGRF-14 (doi 10.5281/zenodo.14012302) along the orbit through `ppigrf`, tabulated.

    Crust and currents in space, 50 to 100 nT on quiet days, are no part of it. Raises
    `SettingsError` if the epoch is outside 1900 to 2030.
    """
    moment = earth.J2000 + np.timedelta64(round(orbit.epoch_days * 86400.0), "s")
    if not np.datetime64(FIRST) <= moment < np.datetime64(LAST):
        raise SettingsError(
            f"--environment.field igrf: IGRF-14 covers {FIRST} to {LAST}, --orbit.epoch-utc is "
            f"{moment}"
        )
    table = Table(lambda t: _igrf(t, orbit), STEP_S)
    return lambda t: table(t)[:3]  # type: ignore[return-value]  # its three components


def _igrf(t: Array, orbit: Orbit) -> Array:
    """B at k instants, T, inertial axes, shape (k, 3)."""
    import ppigrf  # only this model needs it, and loading it costs half a second

    x, y, z = (np.broadcast_to(np.asarray(part, float), t.shape) for part in orbit.direction(t))
    s = np.maximum(np.hypot(x, y), OFF_POLE)
    azimuth = np.arctan2(y, x)
    longitude = azimuth - earth.sidereal_angle(orbit.epoch_days) - earth.ROTATION_RATE * t
    middle = earth.J2000 + np.timedelta64(
        round((orbit.epoch_days * 86400.0 + float(t.mean())) * 1e3), "ms"
    )  # the field drifts by 100 nT a year
    outward, south, east = (
        TESLA * part[0]
        for part in ppigrf.igrf_gc(
            orbit.radius_at(t) / 1e3,
            np.rad2deg(np.arctan2(s, z)),
            np.rad2deg(longitude),
            middle.astype("datetime64[ms]").item(),
        )
    )
    up = np.stack([x, y, z])
    southward = np.stack([z * x / s, z * y / s, -s])
    eastward = np.stack([-y / s, x / s, np.zeros_like(s)])
    return (outward * up + south * southward + east * eastward).T
