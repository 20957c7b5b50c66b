"""The gyro's errors are what their data sheet's words mean: slopes of the Allan deviation."""

from dataclasses import replace

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.sensors.gyro import (
    Gyro,
    angle_random_walk,
    bias_instability,
    build_gyro,
    rate_random_walk,
)
from simsat.sensors.presets import SMALLSAT
from simsat.sensors.sheets import GyroSheet
from tests.simsat.sensors.cases import TICK, tumbling

NOTHING = GyroSheet(
    angle_random_walk_deg_sqrt_h=0.0, bias_instability_deg_h=0.0,
    rate_random_walk_deg_h_sqrt_h=0.0, bias_deg_h=0.0, scale_factor_ppm=0.0,
    misalignment_mrad=0.0, range_deg_s=400.0,
)  # fmt: skip
DEG_H = np.radians(1.0) / 3600.0
HOUR = 3600.0


def allan_deviation(rate: Array, tick: float, averaged: int) -> float:
    """Overlapping Allan deviation of a rate at an averaging time of so many samples, rms over axes
    (IEEE Std 952-1997, equation C.9)."""
    angle = np.concatenate([np.zeros((1, 3)), np.cumsum(rate, axis=0) * tick])
    m, tau = averaged, averaged * tick
    second = angle[2 * m :] - 2.0 * angle[m:-m] + angle[: -2 * m]
    return float(np.sqrt(np.mean(second**2) / (2.0 * tau**2)))


def test_angle_random_walk_is_the_slope_of_minus_a_half() -> None:
    """N / sqrt(tau), read at an hour: IEEE Std 952-1997, equation C.13."""
    sheet = replace(NOTHING, angle_random_walk_deg_sqrt_h=0.15)
    rate = angle_random_walk(sheet, 200_000, TICK, np.random.default_rng(1))
    for averaged in (1, 10, 100, 1000):
        hours = averaged * TICK / HOUR
        told = allan_deviation(rate, TICK, averaged) / DEG_H
        assert told == pytest.approx(0.15 / np.sqrt(hours), rel=0.06)


def test_rate_random_walk_is_the_slope_of_a_half() -> None:
    """K sqrt(tau / 3), equation C.19."""
    sheet = replace(NOTHING, rate_random_walk_deg_h_sqrt_h=3.0)
    rate = rate_random_walk(sheet, 1_000_000, TICK, np.random.default_rng(2))
    for averaged in (100, 1000, 5000):
        hours = averaged * TICK / HOUR
        told = allan_deviation(rate, TICK, averaged) / DEG_H
        assert told == pytest.approx(3.0 * np.sqrt(hours / 3.0), rel=0.1)


def test_bias_instability_is_the_highest_point_of_its_own_allan_curve() -> None:
    """The stated figure, 1.89 correlation times out: equation B.17 and the text after it."""
    sheet = replace(NOTHING, bias_instability_deg_h=5.0, correlation_time_s=10.0)
    rate = bias_instability(sheet, 2_000_000, TICK, np.random.default_rng(3))
    peak = round(1.89 * 10.0 / TICK)
    told = allan_deviation(rate, TICK, peak) / DEG_H
    assert told == pytest.approx(5.0, rel=0.05)
    for other in (peak // 3, peak * 3):
        assert allan_deviation(rate, TICK, other) / DEG_H < told


def test_bias_instability_is_as_large_at_the_start_as_later() -> None:
    sheet = replace(NOTHING, bias_instability_deg_h=5.0, correlation_time_s=1e4)
    starts = [
        bias_instability(sheet, 2, TICK, np.random.default_rng(seed))[0] for seed in range(500)
    ]
    assert np.std(starts) / DEG_H == pytest.approx(5.0 / 0.618, rel=0.1)


def test_what_is_drawn_once_differs_between_flights_as_stated() -> None:
    sheet = replace(NOTHING, bias_deg_h=2.0, scale_factor_ppm=500.0, misalignment_mrad=0.3)
    gyros = [build_gyro(sheet, 3, TICK, np.random.default_rng(seed)) for seed in range(700)]
    errors = np.array([gyro.gain - np.eye(3) for gyro in gyros])
    on, off = np.eye(3, dtype=bool), ~np.eye(3, dtype=bool)
    assert errors[:, on].std() == pytest.approx(500e-6, rel=0.08)
    assert errors[:, off].std() == pytest.approx(0.3e-3, rel=0.08)
    assert np.std([gyro.error[0] for gyro in gyros]) / DEG_H == pytest.approx(2.0, rel=0.08)


def test_scale_and_misalignment_act_on_the_rate_and_the_range_cuts_it() -> None:
    plant = tumbling()
    gain = np.array([[1.01, 0.0, 0.02], [0.0, 1.0, 0.0], [0.0, 0.0, 0.9]])
    rows = np.arange(plant.log.rows)
    seen = Gyro(gain, np.zeros((plant.log.rows, 3)), 9.0)(plant, rows)
    w = plant.rates
    np.testing.assert_allclose(seen[:, 0], 1.01 * w[:, 0] + 0.02 * w[:, 2], rtol=1e-12)
    np.testing.assert_allclose(seen[:, 2], 0.9 * w[:, 2], rtol=1e-12)
    cut = Gyro(gain, np.zeros((plant.log.rows, 3)), 0.05)(plant, rows)
    assert np.abs(cut).max() == 0.05


def test_the_same_seed_draws_the_same_and_another_draws_others() -> None:
    first, again, other = (
        build_gyro(SMALLSAT.gyro, 50, TICK, np.random.default_rng(seed)) for seed in (4, 4, 5)
    )
    np.testing.assert_array_equal(first.error, again.error)
    np.testing.assert_array_equal(first.gain, again.gain)
    assert np.abs(first.error - other.error).max() > 0.0
