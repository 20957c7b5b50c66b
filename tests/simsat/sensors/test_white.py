"""Instruments: figures come out as stated, seeds repeat, and metrics ignore them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.measurement import Measurement
from simsat.environment import EnvironmentSettings, OrbitSettings
from simsat.environment.environment import build_orbit
from simsat.flight.loop import sense_truth
from simsat.flight.mission import prepare
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS
from simsat.plant.plant import Plant
from simsat.results.metrics import judge
from simsat.sensors.build import Span, build_sense
from simsat.sensors.errors import BLOCK, Errors
from simsat.sensors.settings import SensorSettings
from simsat.sensors.suite import Suite
from simsat.sensors.white import WhiteNoise
from simsat.settings import FlightSettings

PERFECT = SensorSettings(
    enabled=True, attitude_noise_arcsec=0.0, gyro_random_walk_deg_sqrt_h=0.0,
    gyro_bias_deg_h=0.0, wheel_speed_noise_rpm=0.0, delay_samples=0,
)  # fmt: skip
TICK, ROWS = 0.05, 41
ORBIT = build_orbit(OrbitSettings())


@pytest.fixture(scope="module")
def plant() -> Plant:
    """Two seconds of tumbling with turning wheels."""
    model = read_model(MODELS / "two_wheel" / "two_wheel.xml")
    plant = Plant(model, TICK, ROWS - 1)
    q = attitude.from_axis_angle(np.array([0.3, -0.8, 0.5]), 2.0)
    plant.reset(q, np.array([0.1, -0.2, 0.15]), np.array([200.0, -300.0]))
    plant.advance(np.array([0.02, -0.03]), ROWS - 1)
    return plant


def instruments(rows: int = ROWS, **changes: Any) -> WhiteNoise:
    return suite_and_noise(rows, **changes)[1]


def suite(rows: int = ROWS, **changes: Any) -> Suite:
    return suite_and_noise(rows, **changes)[0]


def suite_and_noise(rows: int, **changes: Any) -> tuple[Suite, WhiteNoise]:
    built = build_sense(replace(PERFECT, **changes), Span(rows, TICK, 2, ORBIT))
    assert isinstance(built, Suite)
    assert isinstance(built.attitudes, WhiteNoise)
    return built, built.attitudes


def drawn(rows: int = ROWS, **changes: Any) -> Errors:
    return instruments(rows, **changes).errors.rows(0, rows - 1)


def assert_same(a: Measurement, b: Measurement) -> None:
    np.testing.assert_array_equal(a.q, b.q)
    np.testing.assert_array_equal(a.omega, b.omega)
    np.testing.assert_array_equal(a.wheel_speed, b.wheel_speed)
    np.testing.assert_array_equal(a.history.omega, b.history.omega)
    np.testing.assert_array_equal(a.history.wheel_speed, b.history.wheel_speed)
    np.testing.assert_array_equal(a.history.t, b.history.t)
    assert a.t == b.t


def test_switched_off_or_perfect_instruments_show_the_truth(plant: Plant) -> None:
    assert build_sense(SensorSettings(), Span(ROWS, TICK, 2, ORBIT)) is sense_truth
    torque = np.array([0.02, -0.03])
    assert_same(suite()(plant, 10, torque), sense_truth(plant, 10, torque))


def test_a_delayed_sample_is_the_one_before(plant: Plant) -> None:
    seen = suite(delay_samples=1)(plant, 10, np.zeros(2))
    np.testing.assert_array_equal(seen.omega, plant.rates[-2])
    np.testing.assert_array_equal(seen.q, plant.attitudes[-2])
    np.testing.assert_array_equal(seen.history.wheel_speed, plant.wheel_speeds[-12:-1])
    assert seen.t == pytest.approx(2.0)


def test_before_the_first_sample_the_start_is_seen() -> None:
    start = prepare(FlightSettings()).build_plant()
    seen = suite(delay_samples=3)(start, 0, np.zeros(2))
    np.testing.assert_array_equal(seen.q, start.attitudes[0])


def test_noise_has_the_stated_size() -> None:
    rows = 20_000
    errors = drawn(rows, attitude_noise_arcsec=10.0, wheel_speed_noise_rpm=2.0)
    degrees = np.degrees(errors.attitude.std(axis=0))
    np.testing.assert_allclose(degrees, 10.0 / 3600.0, rtol=0.03)  # 6 sigma of the estimate
    rpm = errors.wheel_speed.std(axis=0) * 60.0 / (2.0 * np.pi)
    np.testing.assert_allclose(rpm, 2.0, rtol=0.03)


def test_gyro_walks_by_the_root_of_time() -> None:
    """What the angle random walk means: after T hours the integral is off by N sqrt(T) degrees."""
    per_window, windows = 1200, 600  # a minute each
    errors = drawn(per_window * windows, gyro_random_walk_deg_sqrt_h=0.15)
    walks = TICK * errors.gyro.reshape(windows, per_window, 3).sum(axis=1)
    np.testing.assert_allclose(np.degrees(walks).std(), 0.15 * np.sqrt(1.0 / 60.0), rtol=0.1)


def test_gyro_bias_stays_the_same_through_a_flight_and_differs_between_flights() -> None:
    biases = [drawn(gyro_bias_deg_h=5.0, seed=seed).gyro for seed in range(400)]
    assert all((bias == bias[0]).all() for bias in biases)
    per_hour = np.degrees([bias[0] for bias in biases]) * 3600.0
    np.testing.assert_allclose(per_hour.std(), 5.0, rtol=0.1)


def test_attitude_noise_is_a_turn_about_body_axes(plant: Plant) -> None:
    sensed, noisy = suite_and_noise(ROWS, attitude_noise_arcsec=60.0)
    seen = sensed(plant, 10, np.zeros(2)).q
    off = attitude.multiply(attitude.conjugate(plant.attitudes[-1]), seen)
    np.testing.assert_allclose(
        attitude.rotation_vector(off), noisy.errors.rows(ROWS - 1, ROWS - 1).attitude[0], atol=1e-12
    )


def test_relative_noise_scales_with_what_is_measured(plant: Plant) -> None:
    sensed, noisy = suite_and_noise(ROWS, relative_noise_percent=3.0)
    seen = sensed(plant, ROWS - 1, np.zeros(2))
    share = seen.history.omega / plant.rates - 1.0
    assert share.std() == pytest.approx(0.03, rel=0.3)
    share = seen.history.wheel_speed / plant.wheel_speeds - 1.0
    assert share.std() == pytest.approx(0.03, rel=0.3)
    expected = noisy.errors.rows(0, ROWS - 1).relative[-1, :3] * attitude.rotation_vector(
        plant.attitudes[-1]
    )
    off = attitude.multiply(attitude.conjugate(plant.attitudes[-1]), seen.q)
    np.testing.assert_allclose(attitude.rotation_vector(off), expected, atol=1e-12)


def test_the_same_seed_gives_the_same_flight_and_metrics_judge_the_truth() -> None:
    settings = FlightSettings(
        model=Path("three_wheel"), angle_deg=20.0, duration_s=10.0,
        environment=EnvironmentSettings(drag=False), sensors=SensorSettings(enabled=True, seed=7),
    )  # fmt: skip
    flights = [prepare(settings).fly() for _ in range(2)]
    np.testing.assert_array_equal(flights[0].plant.attitudes, flights[1].plant.attitudes)
    other = prepare(replace(settings, sensors=SensorSettings(enabled=True, seed=8))).fly()
    assert np.abs(other.plant.attitudes - flights[0].plant.attitudes).max() > 1e-9
    truth = attitude.error_angle(flights[0].plant.attitudes[-1], settings.q_target)
    metrics = judge(flights[0], settings.q_target)
    assert metrics["final_error_deg"] == pytest.approx(float(np.degrees(truth)))
    assert metrics["final_error_deg"] < 0.5


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"attitude_noise_arcsec": -1.0}, "--sensors.attitude-noise-arcsec is -1"),
        ({"gyro_bias_deg_h": float("nan")}, "--sensors.gyro-bias-deg-h is nan"),
        ({"delay_samples": -1}, "--sensors.delay-samples is -1"),
        ({"seed": -5}, "--sensors.seed is -5"),
    ],
)
def test_figures_below_zero_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        build_sense(replace(PERFECT, **changes), Span(ROWS, TICK, 2, ORBIT))


def test_errors_of_a_long_flight_are_drawn_in_blocks_that_the_seed_decides() -> None:
    """Asked in any order and as often as one likes, over the seam of two blocks too."""
    table = instruments(3 * BLOCK, gyro_random_walk_deg_sqrt_h=0.15, seed=7).errors
    first = table.rows(BLOCK - 3, BLOCK + 4).gyro
    assert first.shape == (8, 3)
    assert len(np.unique(first)) == 24  # no block repeats another
    table.rows(2 * BLOCK + 5, 2 * BLOCK + 9)
    np.testing.assert_array_equal(table.rows(BLOCK - 3, BLOCK + 4).gyro, first)
    again = instruments(2 * BLOCK, gyro_random_walk_deg_sqrt_h=0.15, seed=7).errors
    np.testing.assert_array_equal(again.rows(BLOCK, BLOCK + 4).gyro, first[3:])
