"""orbit.png shows what an orbit brings."""

from pathlib import Path

import numpy as np
import pytest

import simsat
from simsat.control.ground import attitude
from simsat.control.interface.plan import Plan
from simsat.environment.components import dot
from simsat.environment.earth import RADIUS, sun_direction
from simsat.results.pictures.orbit_picture import draw_orbit, field_across, in_shadow


def law(brief: object) -> object:
    """Some torque, some dipole."""
    return lambda now: Plan(np.array([1e-6, -1e-6]), dipole=np.array([0.1, -0.2, 0.05]))


@pytest.fixture(scope="module")
def flown() -> simsat.FlightResult:
    return simsat.fly(
        "two_wheel_rods", controller=law, duration_s=6000.0, sample_s=0.5, keep_s=10.0,
        nmpc={"period": 5.0},
    )  # fmt: skip


def test_a_craft_with_rods_has_five_panels_and_the_shadow_in_each(
    flown: simsat.FlightResult, tmp_path: Path
) -> None:
    figure = draw_orbit(flown.flight, flown.mission)
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert labels == ["error, deg", "momentum along n, mNms", "dipole, A m$^2$",
                      "wheel speed, rpm", "|b x n|"]  # fmt: skip
    assert all(len(ax.collections) == 1 for ax in figure.axes)
    assert [len(ax.lines) for ax in figure.axes] == [2, 1, 3, 2, 1]
    drawn = np.asarray(figure.axes[2].lines[1].get_ydata())
    np.testing.assert_array_equal(drawn[1:], np.full(600, -0.2))
    flown.save(tmp_path / "run")
    assert (tmp_path / "run" / "orbit.png").stat().st_size > 20_000


def test_a_craft_with_all_wheels_and_no_rods_has_two() -> None:
    result = simsat.fly("three_wheel", duration_s=5.0)
    assert len(result.plot_orbit().axes) == 2


def test_a_short_flight_keeps_no_picture_of_an_orbit(tmp_path: Path) -> None:
    simsat.fly("two_wheel", duration_s=1.0).save(tmp_path / "run")
    assert not (tmp_path / "run" / "orbit.png").exists()


def test_the_field_lies_across_n_by_the_sine_of_their_angle(flown: simsat.FlightResult) -> None:
    t = flown.flight.plant.log.t[:5]
    q = flown.flight.plant.attitudes[:5]
    n = np.array([0.0, 0.0, 1.0])
    b = attitude.normalized(flown.mission.environment.field_N(t))
    cosine = np.sum(b * (attitude.rotation_matrix(q) @ n), axis=1)
    expected = np.sqrt(1.0 - cosine**2)
    np.testing.assert_allclose(field_across(flown.mission, t, q, n), expected, atol=1e-12)


def test_the_shadow_is_behind_the_earth(flown: simsat.FlightResult) -> None:
    orbit = flown.mission.environment.orbit
    t = np.arange(0.0, 6000.0, 20.0)
    dark = in_shadow(flown.mission, t) > 0.5
    assert 0.1 < dark.mean() < 0.45
    sun = sun_direction(orbit.epoch_days)
    along = np.asarray(dot(orbit.position(t), sun))
    across = np.sqrt(orbit.radius_at(t) ** 2 - along**2)
    np.testing.assert_array_equal(dark, (along < 0.0) & (across < RADIUS))
