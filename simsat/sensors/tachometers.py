"""Wheel tachometers: noise, and the step between speeds that can be told."""

from dataclasses import dataclass

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.mjcf.wheels import RPM
from simsat.plant.plant import Plant
from simsat.sensors.sheets import TachometerSheet
from simsat.sensors.suite import Rows


@dataclass(frozen=True)
class Tachometers:
    """One for each wheel, with its errors drawn beforehand."""

    error: Array
    """rad/s, shape (rows, m)."""
    resolution: float
    """rad/s; 0 for none."""

    def __call__(self, plant: Plant, rows: Rows) -> Array:
        """What they read at these samples, rad/s, shape (k, m)."""
        speed = plant.wheel_speeds[rows] + self.error[rows]
        step = self.resolution
        return step * np.round(speed / step) if step > 0.0 else speed


def build_tachometers(
    sheet: TachometerSheet, rows: int, wheels: int, rng: np.random.Generator
) -> Tachometers:
    """Tachometers of this kind for a flight of so many samples."""
    error = sheet.noise_rpm * RPM * rng.standard_normal((rows, wheels))
    return Tachometers(error, sheet.resolution_rpm * RPM)
