"""A three-axis gyro: scale factor, misalignment, bias, random walks, range.

    reading = (1 + E) omega + b(t) + N / sqrt(tick) n        b' = Gauss-Markov + K n'

with white n: angle random walk N, rate random walk K, bias instability as a first-order
Gauss-Markov process. Source: IEEE Std 952-1997, annexes B and C; the Gauss-Markov process's Allan
deviation peaks at 0.618 of its standard deviation, 1.89 correlation times out (equation B.17).
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from simsat.control.ground.arrays import Array, Matrix3
from simsat.plant.plant import Plant
from simsat.sensors.sheets import GyroSheet
from simsat.sensors.suite import Rows
from simsat.sensors.units import (
    DEG_PER_HOUR,
    DEG_PER_HOUR_PER_ROOT_HOUR,
    DEG_PER_ROOT_HOUR,
    PPM,
)

ALLAN_PEAK = 0.618
"""Highest Allan deviation of a Gauss-Markov process over its standard deviation."""


@dataclass(frozen=True)
class Gyro:
    """A gyro with its errors drawn beforehand."""

    gain: Matrix3
    """1 + E: rows are the sensitive axes in body axes."""
    error: Array
    """Bias and noise, rad/s, shape (rows, 3)."""
    range: float
    """rad/s."""

    def __call__(self, plant: Plant, rows: Rows) -> Array:
        """What it reads at these samples, rad/s, shape (k, 3)."""
        reading = plant.rates[rows] @ self.gain.T + self.error[rows]
        return np.clip(reading, -self.range, self.range)


def build_gyro(sheet: GyroSheet, rows: int, tick: float, rng: np.random.Generator) -> Gyro:
    """A gyro of this kind for a flight of so many samples, `tick` (s) apart."""
    scale = sheet.scale_factor_ppm * PPM * np.diag(rng.standard_normal(3))
    skew = 1e-3 * sheet.misalignment_mrad * rng.standard_normal((3, 3))
    turn_on = sheet.bias_deg_h * DEG_PER_HOUR * rng.standard_normal(3)
    drift = bias_instability(sheet, rows, tick, rng) + rate_random_walk(sheet, rows, tick, rng)
    return Gyro(
        gain=np.eye(3) + scale + skew - np.diag(np.diag(skew)),
        error=turn_on + drift + angle_random_walk(sheet, rows, tick, rng),
        range=math.radians(sheet.range_deg_s),
    )


def angle_random_walk(sheet: GyroSheet, rows: int, tick: float, rng: np.random.Generator) -> Array:
    """White noise on the rate, rad/s, shape (rows, 3)."""
    density = sheet.angle_random_walk_deg_sqrt_h * DEG_PER_ROOT_HOUR
    return density / math.sqrt(tick) * rng.standard_normal((rows, 3))


def rate_random_walk(sheet: GyroSheet, rows: int, tick: float, rng: np.random.Generator) -> Array:
    """The bias's random walk from zero, rad/s, shape (rows, 3)."""
    density = sheet.rate_random_walk_deg_h_sqrt_h * DEG_PER_HOUR_PER_ROOT_HOUR
    steps = density * math.sqrt(tick) * rng.standard_normal((rows, 3))
    steps[0] = 0.0
    return np.cumsum(steps, axis=0)


def bias_instability(sheet: GyroSheet, rows: int, tick: float, rng: np.random.Generator) -> Array:
    """The Gauss-Markov process, at home in its distribution from the start, rad/s, (rows, 3)."""
    deviation = bias_instability_deviation(sheet)
    keep = math.exp(-tick / sheet.correlation_time_s)
    noise = deviation * math.sqrt(1.0 - keep**2) * rng.standard_normal((rows, 3))
    noise[0] = deviation * rng.standard_normal(3)
    return lfilter([1.0], [1.0, -keep], noise, axis=0)


def bias_instability_deviation(sheet: GyroSheet) -> float:
    """Standard deviation of the Gauss-Markov process whose Allan deviation peaks at the sheet's
    bias instability, rad/s."""
    return sheet.bias_instability_deg_h * DEG_PER_HOUR / ALLAN_PEAK
