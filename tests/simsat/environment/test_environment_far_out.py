"""Orbits up to the geostationary one, beyond, and around the Sun: what acts there, by formula."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.environment import EnvironmentSettings, OrbitSettings, build_environment
from simsat.environment.earth import (
    AU,
    MU,
    MU_SUN,
    RADIUS,
    ROTATION_RATE,
    days_since_j2000,
    sun_direction,
)
from simsat.environment.environment import build_orbit
from simsat.environment.orbit import circular_orbit
from simsat.environment.solar_pressure import PRESSURE, sunlit
from simsat.flight.mission import prepare
from simsat.results.summary import describe_mission
from simsat.settings import FlightSettings
from tests.simsat.environment.test_environment_torques import (
    CENTRE,
    GENERIC,
    HALF,
    J,
    box,
    craft,
    environment,
)

GEO_KM = 35786.03  # above 6378.137 km: Vallado, section 1.1, 42,164.17 km
GEO = OrbitSettings(altitude_km=GEO_KM, inclination_deg=0.0)
EVERYTHING = EnvironmentSettings(solar_pressure=True, magnetic=True)


def names(orbit: OrbitSettings) -> list[str]:
    return [name for name, _ in build_environment(craft(), orbit, EVERYTHING).models]


def test_a_geostationary_satellite_turns_with_the_earth() -> None:
    orbit = circular_orbit(GEO)
    assert orbit.rate == pytest.approx(ROTATION_RATE, rel=1e-5)
    assert orbit.period == pytest.approx(86164.1, abs=0.5)  # a sidereal day


@pytest.mark.parametrize("altitude_km", [500.0, 20200.0, GEO_KM, 300000.0])
def test_gravity_gradient_is_three_times_the_orbit_rate_squared(altitude_km: float) -> None:
    """tau = 3 n^2 r x J r, with n from Kepler's third law."""
    env = environment(orbit=OrbitSettings(altitude_km=altitude_km), gravity_gradient=True)
    radius = 1e3 * altitude_km + RADIUS
    r = attitude.rotation_matrix(GENERIC).T @ np.array(env.orbit.direction(0.0))
    expected = 3.0 * MU / radius**3 * np.cross(r, J @ r)
    np.testing.assert_allclose(env.torque(0.0, GENERIC), expected, rtol=1e-12)


def test_the_longest_eclipse_of_a_geostationary_satellite_is_the_textbook_one() -> None:
    """69.4 min at the equinoxes (Soop, Handbook of Geostationary Orbits, section 6.3, without
    penumbra: 2 asin(RE / R) / n), none at the solstices."""
    for epoch, minutes in (("2026-03-20T14:46:00", 69.4), ("2026-06-21T08:24:00", 0.0)):
        orbit = build_orbit(replace(GEO, epoch_utc=epoch))
        t = np.arange(0.0, orbit.period, 10.0)
        sun = sun_direction(orbit.epoch_days)
        dark = np.sum(sunlit(orbit.direction(t), sun, orbit.radius_at(0.0)) == 0.0) / 6.0
        assert dark == pytest.approx(minutes, abs=0.4)


def test_what_reaches_how_far() -> None:
    everything = ["gravity_gradient", "drag", "solar_pressure", "magnetic"]
    assert names(OrbitSettings(altitude_km=2000.0)) == everything
    without_air = ["gravity_gradient", "solar_pressure", "magnetic"]
    assert names(OrbitSettings(altitude_km=2001.0)) == without_air
    assert names(GEO) == without_air
    assert names(OrbitSettings(altitude_km=58000.0)) == ["gravity_gradient", "solar_pressure"]
    assert names(OrbitSettings(sun_distance_au=1.0)) == ["solar_pressure"]


def test_the_dipole_falls_with_the_cube() -> None:
    """100 nT at the geostationary orbit: 30 uT (RE / R)^3."""
    near, far = (
        np.linalg.norm(
            environment(orbit=o, magnetic=True, dipole_Am2=(0, 0, 1)).torque(0.0, GENERIC)
        )
        for o in (replace(GEO, altitude_km=500.0), GEO)
    )
    ratio = (6878.1366 / (GEO_KM + 6378.1366)) ** 3
    assert far / near == pytest.approx(ratio, rel=1e-6)
    assert 3e-8 < far < 2.2e-7  # Nm on 1 A m^2, of 1.05e-7 T across at the equator


@pytest.mark.parametrize("distance", [0.3, 1.0, 1.013, 5.2])
def test_around_the_sun_only_sunlight_is_left(distance: float) -> None:
    """On a black box, a beam from the Sun: P (AU / R)^2 of what each face shows it."""
    orbit = OrbitSettings(sun_distance_au=distance)
    env = environment(orbit=orbit, spacecraft=craft(box(reflectivity=0.0)), solar_pressure=True)
    sun_N = np.array(sun_direction(days_since_j2000(orbit.epoch_utc)))
    s = attitude.rotation_matrix(GENERIC).T @ sun_N
    faces = 4.0 * np.prod(HALF) / HALF
    normal, area = np.concatenate([np.eye(3), -np.eye(3)]), np.tile(faces, 2)
    lit = area * np.maximum(normal @ s, 0.0)
    centre = lit @ (CENTRE + HALF * normal)
    expected = -PRESSURE / distance**2 * np.cross(centre, s)
    np.testing.assert_allclose(env.torque(0.0, GENERIC), expected, rtol=1e-9)


def test_the_path_around_the_sun_is_kepler_s() -> None:
    """A year at 1 AU; the Sun moves as seen from the Earth, to what its ellipse adds."""
    orbit = circular_orbit(OrbitSettings(sun_distance_au=1.0))
    assert orbit.period / 86400.0 == pytest.approx(365.25, abs=0.02)
    assert orbit.rate**2 * (1.0 * AU) ** 3 == pytest.approx(MU_SUN)
    for days in (0.0, 30.0, 90.0):
        seen = np.array(sun_direction(orbit.epoch_days + days))
        ours = -np.array(orbit.direction(86400.0 * days))
        assert np.degrees(np.arccos(np.clip(seen @ ours, -1.0, 1.0))) < 2.0
    mars = build_orbit(OrbitSettings(sun_distance_au=1.523679))
    assert mars.period / 86400.0 == pytest.approx(686.97, abs=0.1)


def test_no_shadow_falls_out_there_and_the_sun_moves_on() -> None:
    env = environment(orbit=OrbitSettings(sun_distance_au=1.0), solar_pressure=True)
    t = np.linspace(0.0, 40 * 86400.0, 200)
    torques = env.torques(t, np.tile(GENERIC, (200, 1)))["solar_pressure"]
    assert np.linalg.norm(torques, axis=1).min() > 1e-8
    assert np.linalg.norm(torques[-1] - torques[0]) > 1e-8
    np.testing.assert_allclose(env.torque(float(t[77]), GENERIC), torques[77], rtol=1e-12)


@pytest.mark.parametrize(
    ("orbit", "said"),
    [
        ({"sun_distance_au": 1.0},
         r"left out, 1.49598e\+08 km from the centre of the Sun: gravity_gradient \(the Sun's is "
         r"\de-14 Nm at most\), drag \(there is no air\), magnetic \(the Earth's field is far"),
        ({"altitude_km": 70000.0},
         r"left out, 76378.1 km from the centre of the Earth: drag \(there is no air above 2000 km"
         r"\), magnetic \(the Earth's field ends 10 Earth radii"),
    ],
)  # fmt: skip
def test_what_does_not_apply_is_said_at_the_start(orbit: dict[str, Any], said: str) -> None:
    mission = prepare(FlightSettings(orbit=OrbitSettings(**orbit), environment=EVERYTHING))
    assert re.search(said, describe_mission(mission))


def test_near_the_earth_nothing_is_left_out() -> None:
    mission = prepare(FlightSettings(environment=EVERYTHING))
    assert mission.environment.left_out == ()
    assert "left out" not in describe_mission(mission)
    off = EnvironmentSettings(drag=False, gravity_gradient=False)
    far = prepare(FlightSettings(orbit=OrbitSettings(sun_distance_au=1.0), environment=off))
    assert far.environment.left_out == ()  # what nobody asked for is not missed
