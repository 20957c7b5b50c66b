"""The orbit, the Sun and the Earth's rotation against their laws and published values."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simsat.control.ground.errors import SettingsError
from simsat.environment import OrbitSettings
from simsat.environment.earth import MU, days_since_j2000, sidereal_angle, sun_direction
from simsat.environment.orbit import circular_orbit


def test_orbit_obeys_newton() -> None:
    orbit = circular_orbit(OrbitSettings())
    t, h = np.linspace(0.0, 6000.0, 7), 0.5
    before, now, after = (np.stack(orbit.position(t + s)) for s in (-h, 0.0, h))
    velocity = (after - before) / (2.0 * h)
    acceleration = (after - 2.0 * now + before) / h**2
    np.testing.assert_allclose(np.stack(orbit.velocity(t)), velocity, atol=1e-3)  # m/s of 7613
    np.testing.assert_allclose(acceleration, -MU * now / orbit.radius**3, atol=1e-5)  # m/s^2 of 8.4


def test_orbit_has_the_stated_plane_and_start() -> None:
    settings = OrbitSettings(
        altitude_km=600.0, inclination_deg=30.0, raan_deg=90.0, arg_latitude_deg=90.0
    )
    orbit = circular_orbit(settings)
    r, v = np.array(orbit.position(0.0)), np.array(orbit.velocity(0.0))
    normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    np.testing.assert_allclose(normal, [np.sin(np.pi / 6), 0.0, np.cos(np.pi / 6)], atol=1e-12)
    # Node on +y; a quarter turn later the spacecraft is furthest north, over -x.
    expected = np.array([-np.cos(np.pi / 6), 0.0, np.sin(np.pi / 6)]) * (6378136.6 + 600e3)
    np.testing.assert_allclose(r, expected, atol=1e-6)


def test_period_at_500_km_is_the_textbook_one() -> None:
    # Wertz and Larson, Space Mission Analysis and Design, 3rd ed., back cover: 94.62 min.
    assert circular_orbit(OrbitSettings()).period / 60.0 == pytest.approx(94.62, abs=0.01)


@pytest.mark.parametrize(
    ("epoch", "right_ascension_deg", "declination_deg"),
    [
        ("2026-03-20T14:46:00", 0.0, 0.0),  # equinoxes and solstices of 2026, US Naval Observatory
        ("2026-06-21T08:24:00", 90.0, 23.44),
        ("2026-09-23T00:05:00", 180.0, 0.0),
        ("2026-12-21T20:50:00", 270.0, -23.44),
    ],
)
def test_sun_stands_where_the_seasons_say(
    epoch: str, right_ascension_deg: float, declination_deg: float
) -> None:
    ra, dec = np.deg2rad([right_ascension_deg, declination_deg])
    expected = [np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)]
    sun = sun_direction(days_since_j2000(epoch))
    assert np.rad2deg(np.linalg.norm(np.array(sun) - expected)) < 0.02  # series: 0.01 degrees


def test_sidereal_angle_is_meeus_example() -> None:
    # Meeus, Astronomical Algorithms, examples 12.a and 12.b: 1987 April 10.
    for epoch, angle_deg in (("1987-04-10", 197.693195), ("1987-04-10T19:21:00", 128.7378734)):
        angle = sidereal_angle(days_since_j2000(epoch))
        assert np.rad2deg(angle) == pytest.approx(angle_deg, abs=1e-5)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"altitude_km": 50.0}, "altitude-km is 50: give a finite number from 150 to 300000"),
        ({"altitude_km": float("nan")}, "altitude-km is nan"),
        ({"raan_deg": float("inf")}, "raan-deg is inf"),
        ({"epoch_utc": "tomorrow"}, "'tomorrow' isn't a date"),
        ({"epoch_utc": ""}, "isn't a date"),
        ({"tle": Path("x.tle"), "sun_distance_au": 1.0}, "one around the Sun: give one of them"),
    ],
)
def test_orbit_settings_are_refused_with_their_value(
    settings: dict[str, Any], message: str
) -> None:
    with pytest.raises(SettingsError, match=message):
        OrbitSettings(**settings)
