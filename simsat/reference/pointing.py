"""References along the orbit: a body axis that points to nadir, to the Sun or to a station.

The attitude is sampled along the flight, through which a cubic spline is laid; its rate is that
spline's derivative. Nadir and Sun are sampled every 10 s, which leaves 1e-8 deg at 500 km, a
station every second.
"""

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternions, Vector3, Vectors3
from simsat.control.ground.errors import SettingsError
from simsat.control.reference.reference import Curve
from simsat.environment import earth
from simsat.environment.orbit import Orbit

STEP_S, STATION_STEP_S = 10.0, 1.0
BEYOND_S = 600.0  # after the flight's end, which plans look over
DAY_S = 86400.0

Directions = Callable[[Array], tuple[Vectors3, Vectors3]]
"""t (k,) -> where the boresight and the second axis are to point, inertial axes, (k, 3) each."""


def pointing(
    directions: Directions, boresight: Vector3, second: Vector3, duration: float, step: float
) -> Curve:
    """The reference whose boresight points exactly and whose second axis as nearly as it can."""
    t = np.arange(-4.0, np.ceil((duration + BEYOND_S) / step) + 4.0) * step
    q = attitude.continuous(turned_to(*directions(t), boresight, second))
    spline = CubicSpline(t, q)
    return Curve(spline, spline.derivative())


def turned_to(
    first_N: Vectors3, second_N: Vectors3, first_B: Vector3, second_B: Vector3
) -> Quaternions:
    """Attitudes, body -> inertial, that turn one body axis along a direction exactly and another
    into the half-plane of a second direction (TRIAD, Wertz section 12.2.2)."""
    frame_N, frame_B = _triad(first_N, second_N), _triad(first_B, second_B)
    matrix = frame_N @ np.swapaxes(frame_B, -1, -2)
    return np.roll(Rotation.from_matrix(matrix).as_quat(), 1, axis=-1)  # scalar first


def _triad(first: Vectors3, second: Vectors3) -> Array:
    """Unit vectors along the first, across both, and across these, as columns."""
    one = attitude.normalized(first)
    two = attitude.normalized(np.cross(first, second))
    return np.stack([one, two, np.cross(one, two)], axis=-1)


def to_nadir(orbit: Orbit) -> Directions:
    """Down, and the velocity."""
    return lambda t: (-np.stack(orbit.direction(t), axis=1), np.stack(orbit.velocity(t), axis=1))


def to_sun(orbit: Orbit) -> Directions:
    """The Sun, and north, from which it is never nearer than 66 degrees."""

    def directions(t: Array) -> tuple[Vectors3, Vectors3]:
        sun = np.array([earth.sun_direction(orbit.epoch_days + s / DAY_S) for s in t])
        return sun, np.broadcast_to([0.0, 0.0, 1.0], sun.shape)

    return directions


def to_station(orbit: Orbit, latitude_deg: float, longitude_deg: float) -> Directions:
    """A place on the ground, also while the Earth is between, and the orbit's normal."""

    def directions(t: Array) -> tuple[Vectors3, Vectors3]:
        r, v = np.stack(orbit.position(t), axis=1), np.stack(orbit.velocity(t), axis=1)
        station, _ = _station(t, orbit, latitude_deg, longitude_deg)
        return station - r, np.cross(r, v)

    return directions


def refuse_unseen(orbit: Orbit, latitude_deg: float, longitude_deg: float, duration: float) -> None:
    """Raise `SettingsError` if the station never sees the craft above its horizon."""
    t = np.arange(0.0, duration + STEP_S, STEP_S)
    station, up = _station(t, orbit, latitude_deg, longitude_deg)
    sight = attitude.normalized(np.stack(orbit.position(t), axis=1) - station)
    highest = float(np.max(np.sum(sight * up, axis=1)))
    if highest <= 0.0:
        raise SettingsError(
            f"--reference station {latitude_deg:g} {longitude_deg:g}: the craft stays below its "
            f"horizon, {np.rad2deg(np.arcsin(highest)):.1f} deg at best in {duration:g} s"
        )


def _station(
    t: Array, orbit: Orbit, latitude_deg: float, longitude_deg: float
) -> tuple[Vectors3, Vectors3]:
    """Place (m) and zenith of a station at sea level on the ellipsoid, inertial axes."""
    latitude, f = np.deg2rad(latitude_deg), earth.FLATTENING
    east = np.deg2rad(longitude_deg) + earth.sidereal_angle(orbit.epoch_days)
    east = east + earth.ROTATION_RATE * t
    c, s = np.cos(latitude) * np.ones_like(t), np.sin(latitude) * np.ones_like(t)
    zenith = np.stack([c * np.cos(east), c * np.sin(east), s], axis=1)
    curvature = earth.RADIUS / np.sqrt(1.0 - f * (2.0 - f) * s**2)
    shrunk = np.array([1.0, 1.0, (1.0 - f) ** 2])
    return curvature[:, None] * zenith * shrunk, zenith
