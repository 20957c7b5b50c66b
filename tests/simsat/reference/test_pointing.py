"""References along the orbit: axes point where they must, by frames of another library."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from skyfield.api import EarthSatellite, load, wgs84

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Vector3
from simsat.control.ground.errors import SettingsError
from simsat.control.reference.reference import Reference
from simsat.environment import OrbitSettings
from simsat.environment.earth import sun_direction
from simsat.environment.orbit import Orbit, circular_orbit
from simsat.environment.orbits.tle import read_orbit
from simsat.reference.build import build_reference
from simsat.reference.frames import j2000_in_date
from simsat.reference.settings import ReferenceSettings

EPOCH = "2026-03-20T12:00:00"
LONG = 6000.0
LINES = (
    "1 99001U 26001A   26079.50000000  .00001000  00000-0  50000-4 0  9998",
    "2 99001  97.4000  40.0000 0011000  90.0000 295.0000 15.21936719    10",
)


def built(*to: str, orbit: Orbit | None = None, duration: float = LONG, **axes: Any) -> Reference:
    orbit = circular_orbit(OrbitSettings()) if orbit is None else orbit
    settings = ReferenceSettings(to=to, **axes)
    return build_reference(settings, attitude.IDENTITY, orbit, EPOCH, duration)


def pointed(reference: Reference, t: Array, axis_B: Vector3) -> Array:
    return attitude.rotation_matrix(reference.attitude(t)) @ np.asarray(axis_B)


TIMES = np.linspace(0.0, LONG, 173)


def test_nadir_looks_down_and_flies_ahead() -> None:
    orbit = circular_orbit(OrbitSettings())
    reference = built("nadir", boresight=(0.0, 1.0, 1.0), second=(1.0, 0.0, 0.0))
    down = -np.stack(orbit.direction(TIMES), axis=1)
    seen = pointed(reference, TIMES, attitude.normalized(np.array([0.0, 1.0, 1.0])))
    np.testing.assert_allclose(seen, down, atol=1e-10)
    ahead = np.stack(orbit.velocity_direction(TIMES), axis=1)
    np.testing.assert_allclose(pointed(reference, TIMES, np.eye(3)[0]), ahead, atol=1e-10)


def test_nadir_turns_once_an_orbit_about_its_normal() -> None:
    """w = n about -y of the local frame (z down, x ahead), whose y axis lies against the normal."""
    orbit = circular_orbit(OrbitSettings())
    rate = built("nadir").rate(TIMES)
    expected = np.array([0.0, -orbit.rate, 0.0])
    np.testing.assert_allclose(rate, np.tile(expected, (len(TIMES), 1)), atol=1e-11)  # rad/s


def test_sun_is_where_the_sun_is_and_follows_it() -> None:
    orbit = circular_orbit(OrbitSettings())
    reference = built("sun", duration=86400.0)
    t = np.linspace(0.0, 86400.0, 50)
    sun = np.array([sun_direction(orbit.epoch_days + s / 86400.0) for s in t])
    np.testing.assert_allclose(pointed(reference, t, np.eye(3)[2]), sun, atol=1e-9)
    a_day = np.linalg.norm(reference.rate(t), axis=1) * 86400.0
    np.testing.assert_allclose(np.rad2deg(a_day), 0.99, atol=0.1)


def test_a_station_is_seen_where_skyfield_has_it(tmp_path: Path) -> None:
    """The direction from the craft to Madrid in the frame of date, through Skyfield's."""
    path = tmp_path / "craft.tle"
    lines = [_with_checksum(line) for line in LINES]
    path.write_text("\n".join(lines))
    reference = built("station", "40.4", "-3.7", orbit=read_orbit(path, EPOCH), duration=86400.0)
    t = np.linspace(0.0, 86400.0, 200)
    times = load.timescale(builtin=True).utc(2026, 3, 20, 12, 0, t)
    craft, madrid = EarthSatellite(*lines).at(times), wgs84.latlon(40.4, -3.7).at(times)
    sight = (madrid.position.m - craft.position.m).T  # ICRF
    of_date = np.einsum("kij,kj->ki", np.moveaxis(times.M, -1, 0), sight)  # and nutation
    angle = np.arccos(np.sum(attitude.normalized(of_date) * pointed(reference, t, np.eye(3)[2]),
                             axis=1))  # fmt: skip
    distance = np.linalg.norm(sight, axis=1)
    across = angle * distance
    assert across.max() < 3000.0  # m: 0.4 s of UT1, nutation, and kilometres of Earth's centre


def _with_checksum(line: str) -> str:
    total = sum(int(c) if c.isdigit() else c == "-" for c in line[:68])
    return f"{line[:68]}{total % 10}"


def test_j2000_is_turned_to_date_as_skyfield_does() -> None:
    ts = load.timescale(builtin=True)
    for year in (1990, 2026, 2045):
        t = ts.utc(year, 3, 20, 12)
        ours = attitude.rotation_matrix(j2000_in_date(t.tt - 2451545.0))
        apart = np.arccos(np.clip((np.trace(ours @ t.M.T) - 1.0) / 2.0, -1.0, 1.0))
        assert np.rad2deg(apart) < 0.006  # nutation; precession is 0.36 deg by 2026


@pytest.mark.parametrize("kind", ["nadir", "sun", "station"])
def test_the_rate_is_the_derivative_of_the_attitude(kind: str) -> None:
    reference = built(kind, *(("40.4", "-3.7") if kind == "station" else ()), duration=43200.0)
    t, h = np.linspace(60.0, 43000.0, 500), 0.05
    before, after = reference.attitude(t - h), reference.attitude(t + h)
    turn = attitude.multiply(attitude.conjugate(before), after)
    numerical = attitude.rotation_vector(turn) / (2.0 * h)
    np.testing.assert_allclose(reference.rate(t), numerical, atol=1e-6)


@pytest.mark.parametrize(
    ("to", "duration", "message"),
    [
        (("station", "0", "150"), 60.0, r"station 0 150: the craft stays below its horizon, -\d"),
        (("station", "91", "0"), LONG, "give latitude .-90 to 90. and longitude"),
        (("station", "1"), LONG, "give latitude"),
        (("station", "north", "1"), LONG, "give latitude"),
        (("station",), LONG, "give latitude"),
        (("station", "nan", "0"), LONG, "give latitude"),
        (("nadir", "1"), LONG, "--reference nadir takes nothing more, not 1"),
        (("nadyr",), LONG, "'nadyr' is none of inertial, nadir, sun, station and no file"),
    ],
)
def test_what_cannot_be_followed_is_refused(
    to: tuple[str, ...], duration: float, message: str
) -> None:
    with pytest.raises(SettingsError, match=message):
        built(*to, duration=duration)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"to": ()}, "--reference: give inertial, nadir"),
        ({"boresight": (0.0, 0.0, 0.0)}, "must be two different axes, not zero"),
        ({"boresight": (2.0, 0.0, 0.0)}, "must be two different axes"),
        ({"second": (math.nan, 0.0, 0.0)}, r"--reference\.second is nan 0 0"),
    ],
)
def test_axes_that_decide_nothing_are_refused(values: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        ReferenceSettings(**values)
