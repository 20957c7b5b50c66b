"""Air density: the table's own consistency, NRLMSIS called directly, the ground track."""

import numpy as np
import pymsis
import pytest

from simsat.environment import OrbitSettings
from simsat.environment.atmosphere import (
    EXPONENTIAL_BANDS,
    exponential_density,
    geodetic,
    nrlmsis_density,
)
from simsat.environment.orbit import circular_orbit


@pytest.mark.parametrize(
    ("altitude_km", "rho"), [(400.0, 3.725e-12), (450.0, 1.585e-12), (500.0, 6.967e-13)]
)
def test_exponential_density_is_the_published_one(altitude_km: float, rho: float) -> None:
    assert exponential_density(altitude_km) == pytest.approx(rho, rel=1e-12, abs=0.0)


def test_every_band_ends_where_the_next_begins() -> None:
    for base, rho, _ in EXPONENTIAL_BANDS[1:]:
        # The printed scale heights close the bands to a part in ten thousand.
        assert exponential_density(base - 1e-9) == pytest.approx(rho, rel=1e-4, abs=0.0)


def test_nrlmsis_along_the_orbit_is_pymsis_at_the_ground_track() -> None:
    orbit = circular_orbit(OrbitSettings())
    density = nrlmsis_density(orbit, 150.0, 150.0, 4.0)
    t = np.array([0.0, 1234.5, 4000.0])
    longitude, latitude, altitude = geodetic(t, orbit)
    direct = pymsis.calculate(
        np.datetime64("2026-03-20T12:00:00.000") + (t * 1e3).astype("timedelta64[ms]"),
        longitude, latitude, altitude, [150.0] * 3, [150.0] * 3, np.full((3, 7), 4.0),
    )  # fmt: skip
    np.testing.assert_allclose(density(t), direct[:, 0], rtol=2e-3)
    one_by_one = np.array([density(float(s)) for s in t])
    np.testing.assert_allclose(one_by_one, np.asarray(density(t)), rtol=1e-12)
    assert density(86400.0 + 100.0) == pytest.approx(density(100.0), abs=0.0)


def test_nrlmsis_feels_the_sun() -> None:
    orbit = circular_orbit(OrbitSettings())
    quiet = nrlmsis_density(orbit, 70.0, 70.0, 4.0)(0.0)
    active = nrlmsis_density(orbit, 250.0, 250.0, 4.0)(0.0)
    assert active > 10.0 * quiet  # the solar cycle moves 500 km by a factor of ten and more


def test_ground_track_is_the_ellipsoid_s() -> None:
    """Against the exact ellipsoid: position from longitude, latitude, altitude and back."""
    orbit = circular_orbit(OrbitSettings(inclination_deg=80.0))
    t = np.linspace(0.0, orbit.period, 13)
    longitude, latitude, altitude = geodetic(t, orbit)
    f, a = 1.0 / 298.25642, 6378136.6
    phi = np.deg2rad(latitude)
    e2 = f * (2.0 - f)
    curvature = a / np.sqrt(1.0 - e2 * np.sin(phi) ** 2)
    z = (curvature * (1.0 - e2) + 1e3 * altitude) * np.sin(phi)
    across = (curvature + 1e3 * altitude) * np.cos(phi)
    x, y, z_N = orbit.position(t)
    np.testing.assert_allclose(z, z_N, atol=2e3)  # 0.01 degrees of latitude
    np.testing.assert_allclose(np.hypot(across, z), orbit.radius, atol=100.0)
    greenwich = np.arctan2(y, x) - np.deg2rad(longitude)
    turned = np.unwrap(greenwich)[[0, -1]]
    assert np.diff(turned)[0] == pytest.approx(7.292115e-5 * orbit.period, rel=1e-6)
