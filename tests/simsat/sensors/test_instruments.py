"""Tachometers, Sun sensor, presets, and what the settings refuse."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simsat.control.ground.attitude import rotation_matrix
from simsat.control.ground.errors import SettingsError
from simsat.environment.earth import sun_direction
from simsat.flight.loop import sense_truth
from simsat.flight.mission import prepare
from simsat.sensors.build import Span, build_sense, build_suite
from simsat.sensors.presets import PRESETS
from simsat.sensors.settings import SensorSettings
from simsat.sensors.sheets import SunSensorSheet, TachometerSheet
from simsat.sensors.sky import Sky
from simsat.sensors.suite import Suite
from simsat.sensors.sun_sensor import build_sun_sensor
from simsat.sensors.tachometers import build_tachometers
from simsat.sensors.truth import TRUTH
from simsat.settings import FlightSettings
from tests.simsat.sensors.cases import ORBIT, ROWS, TICK, tumbling

SPAN = Span(ROWS, TICK, 2, ORBIT)
RPM = 2.0 * np.pi / 60.0


def test_tachometers_tell_steps_with_noise_before_them() -> None:
    plant, rows = tumbling(), np.arange(ROWS)
    exact = build_tachometers(TachometerSheet(0.0, 0.0), ROWS, 2, np.random.default_rng(0))
    np.testing.assert_array_equal(exact(plant, rows), plant.wheel_speeds)
    coarse = build_tachometers(TachometerSheet(7.0, 0.0), ROWS, 2, np.random.default_rng(0))
    steps = coarse(plant, rows) / (7.0 * RPM)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert np.abs(coarse(plant, rows) - plant.wheel_speeds).max() <= 3.5 * RPM * (1 + 1e-9)
    noisy = build_tachometers(TachometerSheet(0.0, 2.0), ROWS, 2, np.random.default_rng(0))
    assert (noisy(plant, rows) - plant.wheel_speeds).std() / RPM == pytest.approx(2.0, rel=0.1)


def test_the_sun_is_where_the_almanac_has_it_within_the_noise_and_the_field() -> None:
    plant, rows = tumbling(), np.arange(1, ROWS)
    sheet = SunSensorSheet(rate_hz=20.0, noise_deg=0.2, field_deg=70.0)
    sensor = build_sun_sensor(sheet, Sky(ORBIT), ROWS, TICK, np.random.default_rng(0))
    sun = np.array(sun_direction(ORBIT.epoch_days))
    true = np.einsum("kji,j->ki", rotation_matrix(plant.attitudes), sun)
    told = sensor(plant, rows)
    inside = true[1:, 0] >= np.cos(np.radians(70.0))
    assert 0 < inside.sum() < len(rows)
    np.testing.assert_allclose([s.t for s in told], plant.log.t[1:][inside])
    off = np.array([s.direction_B for s in told]) - true[1:][inside]
    assert np.sqrt(np.sum(off**2, axis=1).mean() / 2.0) == pytest.approx(np.radians(0.2), rel=0.1)
    np.testing.assert_array_equal(told[0].direction_N, sun)


def test_there_is_no_sun_in_the_earths_shadow() -> None:
    half = ORBIT.period / 2.0
    sky = Sky(ORBIT)
    t = np.linspace(0.0, 2.0 * half, 2001)
    dark = ~sky.lit(t)
    assert dark.any()
    behind = np.sum(sky.nadir_N(t[dark]) * sky.sun_N, axis=1)  # the Sun is on the Earth's side
    assert (behind > np.cos(np.arcsin(6378136.6 / 6878136.6))).all()


def test_suites_of_truth_and_instruments_agree_where_there_is_no_error() -> None:
    plant = tumbling()
    a, b = TRUTH(plant, 10, np.zeros(2)), sense_truth(plant, 10, np.zeros(2))
    np.testing.assert_array_equal(a.q, b.q)
    np.testing.assert_array_equal(a.history.omega, b.history.omega)
    np.testing.assert_array_equal(a.history.wheel_speed, b.history.wheel_speed)


@pytest.mark.parametrize("preset", PRESETS)
def test_the_same_seed_gives_the_same_readings(preset: Any) -> None:
    plant = tumbling()
    told = [
        build_sense(SensorSettings(preset=preset, seed=seed), SPAN)(plant, 40, np.zeros(2))
        for seed in (3, 3, 4)
    ]
    np.testing.assert_array_equal(told[0].history.omega, told[1].history.omega)
    np.testing.assert_array_equal(told[0].q, told[1].q)
    assert np.abs(told[0].history.omega - told[2].history.omega).max() > 0.0
    assert np.abs(told[0].wheel_speed - told[2].wheel_speed).max() > 0.0


def test_leaving_an_instrument_out_changes_no_other() -> None:
    plant = tumbling()
    settings = SensorSettings(preset="smallsat", seed=3)
    with_sun = build_suite(settings, SPAN)
    assert settings.sheet is not None
    without = replace(with_sun, sights=())
    assert isinstance(without, Suite)
    a, b = (suite(plant, 20, np.zeros(2)) for suite in (with_sun, without))
    np.testing.assert_array_equal(a.history.omega, b.history.omega)
    assert b.sightings == ()


def test_better_presets_are_better_in_every_figure() -> None:
    cubesat, smallsat, highend = (PRESETS[name] for name in ("cubesat", "smallsat", "highend"))
    for worse, better in ((cubesat, smallsat), (smallsat, highend)):
        assert worse.tracker.across_arcsec > better.tracker.across_arcsec
        assert worse.tracker.latency_s > better.tracker.latency_s
        assert worse.tracker.rate_limit_deg_s < better.tracker.rate_limit_deg_s
        assert worse.gyro.angle_random_walk_deg_sqrt_h > better.gyro.angle_random_walk_deg_sqrt_h
        assert worse.gyro.bias_instability_deg_h > better.gyro.bias_instability_deg_h


def test_a_figure_can_be_replaced() -> None:
    settings = SensorSettings(
        preset="smallsat", figure=("tracker.rate-limit-deg-s=7", "tracker.boresight=0 1 0")
    )
    assert settings.sheet is not None
    assert settings.sheet.tracker.rate_limit_deg_s == 7.0
    assert settings.sheet.tracker.boresight == (0.0, 1.0, 0.0)
    assert settings.sheet.gyro == PRESETS["smallsat"].gyro


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"preset": "nanosat"}, "--sensors.preset is 'nanosat': give one of cubesat, smallsat"),
        ({"preset": "cubesat", "enabled": True}, "leave out --sensors.enabled"),
        ({"figure": ("gyro.range-deg-s=3",)}, "give --sensors.preset too"),
        ({"preset": "cubesat", "figure": ("gyro",)}, "--sensors.figure is 'gyro': give NAME="),
        ({"preset": "cubesat", "figure": ("gyro.x=3",)}, "no setting 'gyro.x': no 'x'; there are"),
        (
            {"preset": "cubesat", "figure": ("gyro.range_deg_s=-1",)},
            "--gyro.range-deg-s is -1: give a finite number above 0",
        ),
        (
            {"preset": "cubesat", "figure": ("tracker.boresight=0 0 0",)},
            "--tracker.boresight is 0 0 0: give an axis",
        ),
    ],
)
def test_what_is_refused(values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SettingsError, match=sentence):
        SensorSettings(**values)


def test_a_flight_on_instruments_ends_and_metrics_judge_the_truth() -> None:
    settings = FlightSettings(
        model=Path("three_wheel"), angle_deg=5.0, duration_s=5.0,
        sensors=SensorSettings(preset="smallsat"),
    )  # fmt: skip
    flights = [prepare(settings).fly() for _ in range(2)]
    np.testing.assert_array_equal(flights[0].plant.attitudes, flights[1].plant.attitudes)
