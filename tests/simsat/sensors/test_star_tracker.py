"""The tracker's attitudes: when they come, how late, how noisy, and when none comes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.environment import OrbitSettings
from simsat.environment.earth import sun_direction
from simsat.environment.environment import build_orbit
from simsat.plant.plant import Plant
from simsat.sensors.sheets import StarTrackerSheet
from simsat.sensors.sky import Sky
from simsat.sensors.star_tracker import StarTracker, build_star_tracker
from tests.simsat.sensors.cases import ORBIT, ROWS, TICK, tumbling

SEES_ALL = StarTrackerSheet(
    rate_hz=4.0, latency_s=0.2, across_arcsec=0.0, about_arcsec=0.0,
    rate_limit_deg_s=100.0, sun_exclusion_deg=0.0, earth_exclusion_deg=0.0,
)  # fmt: skip
ARCSEC = np.radians(1.0 / 3600.0)


def tracker(rows: int = ROWS, seed: int = 0, **changes: Any) -> StarTracker:
    sheet = replace(SEES_ALL, **changes)
    return build_star_tracker(sheet, Sky(ORBIT), rows, TICK, np.random.default_rng(seed))


def zenith_looking(**changes: Any) -> tuple[Plant, StarTracker]:
    """A craft at rest in body axes along the inertial ones, whose tracker looks at the zenith."""
    plant = at_rest()
    zenith = -Sky(ORBIT).nadir_N(np.zeros(1))[0]
    return plant, tracker(boresight=tuple(zenith), **changes)


def at_rest() -> Plant:
    plant = Plant(tumbling().model, TICK, ROWS - 1)
    plant.reset(attitude.IDENTITY)
    plant.advance(np.zeros(2), ROWS - 1)
    return plant


def test_fixes_are_of_their_own_time_and_come_late() -> None:
    plant, sees = zenith_looking()
    assert sees.fixes(plant, np.array([0]))[0].t == 0.0
    for row in range(1, 60):
        told = sees.fixes(plant, np.array([row]))
        due = row > 4 and (row - 4) % 5 == 0  # 4 Hz is every fifth sample, 0.2 s are four
        assert [fix.t for fix in told] == ([pytest.approx(TICK * (row - 4))] if due else [])


def test_asking_for_several_samples_gives_what_asking_one_by_one_does() -> None:
    plant, sees = zenith_looking(across_arcsec=10.0)
    together = sees.fixes(plant, np.arange(1, 31))
    single = [fix for row in range(1, 31) for fix in sees.fixes(plant, np.array([row]))]
    assert [fix.t for fix in together] == [fix.t for fix in single]
    assert all((a.q == b.q).all() for a, b in zip(together, single, strict=True))


@pytest.mark.parametrize("rate_hz", [1.0, 3.0, 8.0, 20.0, 90.0])
def test_the_rate_is_met_on_the_average_or_once_a_sample(rate_hz: float) -> None:
    plant, sees = zenith_looking(rate_hz=rate_hz)
    seconds = (ROWS - 1) * TICK
    found = sees.finds(plant, np.arange(1, ROWS)).sum()
    assert abs(found - min(rate_hz, 20.0) * seconds) <= 1


def test_noise_is_as_stated_across_and_about_the_boresight() -> None:
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    sees = tracker(40_000, across_arcsec=6.0, about_arcsec=40.0, boresight=tuple(5.0 * axis))
    about = sees.error @ axis
    across = sees.error - about[:, None] * axis
    assert about.std() / ARCSEC == pytest.approx(40.0, rel=0.02)
    assert np.sqrt(np.mean(np.sum(across**2, axis=1)) / 2.0) / ARCSEC == pytest.approx(
        6.0, rel=0.02
    )
    np.testing.assert_allclose(sees.covariance @ axis, (40.0 * ARCSEC) ** 2 * axis, rtol=1e-9)
    np.testing.assert_allclose(
        np.cov(sees.error.T), sees.covariance, atol=0.03 * (40 * ARCSEC) ** 2
    )


def test_a_fix_is_the_truth_turned_by_the_error() -> None:
    plant, sees = zenith_looking(across_arcsec=600.0)
    fix = sees.fixes(plant, np.array([9]))[0]
    off = attitude.multiply(attitude.conjugate(plant.attitudes[5]), fix.q)
    np.testing.assert_allclose(attitude.rotation_vector(off), sees.error[5], atol=1e-12)


def test_it_is_blind_while_the_body_turns_too_fast() -> None:
    plant = tumbling()
    rate = np.degrees(np.linalg.norm(plant.rates, axis=1))
    free, slow = tracker(rate_hz=20.0), tracker(rate_hz=20.0, rate_limit_deg_s=float(rate.mean()))
    rows = np.arange(1, ROWS)
    fast = rate[1:] > rate.mean()
    assert 0 < fast.sum() < len(rows)
    found = slow.finds(plant, rows)
    assert not found[fast].any()
    np.testing.assert_array_equal(found[~fast], free.finds(plant, rows)[~fast])


@pytest.mark.parametrize("exclusion", [20.0, 50.0, 80.0])
def test_the_sun_blinds_it_inside_the_exclusion_angle(exclusion: float) -> None:
    """Boresights on the great circle from the Sun away from the Earth."""
    plant, rows = at_rest(), np.array([5])
    sun = np.array(sun_direction(ORBIT.epoch_days))
    zenith = -Sky(ORBIT).nadir_N(np.zeros(1))[0]
    aside = np.cross(np.cross(sun, zenith), sun)
    aside /= np.linalg.norm(aside)
    for off, sees_stars in ((exclusion - 1.0, False), (exclusion + 1.0, True)):
        angle = np.radians(off)
        boresight = tuple(np.cos(angle) * sun + np.sin(angle) * aside)
        sees = tracker(rate_hz=20.0, sun_exclusion_deg=exclusion, boresight=boresight)
        assert bool(sees.sees(plant, rows)[0]) is sees_stars


@pytest.mark.parametrize("exclusion", [0.0, 25.0])
def test_the_limb_of_the_earth_blinds_it(exclusion: float) -> None:
    """The limb is asin(R / r) from nadir: 68.0 deg at 500 km."""
    plant, rows = at_rest(), np.array([5])
    nadir = Sky(ORBIT).nadir_N(plant.log.t[rows])[0]
    aside = np.cross(nadir, [0.0, 0.0, 1.0])
    aside /= np.linalg.norm(aside)
    limb = np.degrees(np.arcsin(6378136.6 / 6878136.6))
    for off, sees_stars in ((limb + exclusion - 0.5, False), (limb + exclusion + 0.5, True)):
        angle = np.radians(off)
        boresight = tuple(np.cos(angle) * nadir + np.sin(angle) * aside)
        sees = tracker(rate_hz=20.0, earth_exclusion_deg=exclusion, boresight=boresight)
        assert bool(sees.sees(plant, rows)[0]) is sees_stars


def test_outliers_are_as_many_and_as_large_as_stated() -> None:
    sees = tracker(100_000, outlier_share=0.03, outlier_deg=5.0)
    size = np.degrees(np.linalg.norm(sees.error, axis=1))
    assert (size > 0.0).mean() == pytest.approx(0.03, rel=0.06)
    assert 4.9 < size.max() <= 5.0
    assert size[0] == 0.0


def test_a_controller_without_an_estimator_is_told_the_last_attitude() -> None:
    plant = tumbling()
    sees = tracker(rate_limit_deg_s=0.5)
    np.testing.assert_array_equal(sees.attitude(plant, ROWS - 1), plant.attitudes[0])
    plant, sees = zenith_looking()
    np.testing.assert_array_equal(sees.attitude(plant, 33), plant.attitudes[25])


def test_around_the_sun_nothing_but_the_sun_stands_in_its_way() -> None:
    orbit = build_orbit(OrbitSettings(sun_distance_au=1.0))
    sky = Sky(orbit)
    t = np.linspace(0.0, 100.0, 5)
    np.testing.assert_allclose(sky.sun_N, -np.array(orbit.direction(0.0)))
    assert sky.lit(t).all()
    assert (sky.from_limb(np.tile(sky.sun_N, (5, 1)), t) > 3.0).all()
