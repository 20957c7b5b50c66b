"""A Sun sensor: the Sun's direction in body axes, where it is in view."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simsat.control.ground.arrays import Array, Vector3
from simsat.control.ground.attitude import rotation_matrix
from simsat.control.interface.measurement import Sighting
from simsat.plant.plant import Plant
from simsat.sensors.sheets import SunSensorSheet
from simsat.sensors.sky import Sky, angles, unit
from simsat.sensors.suite import Rows


@dataclass(frozen=True)
class SunSensor:
    """A sensor with its errors drawn beforehand."""

    sheet: SunSensorSheet
    sky: Sky
    tick: float
    error: Array
    """Turn of the direction, rad, shape (rows, 3)."""

    def __call__(self, plant: Plant, rows: Rows) -> tuple[Sighting, ...]:
        """The Sun, at those of the samples that see it."""
        seen = rows[self.sees(plant, rows)]
        deviation = math.radians(self.sheet.noise_deg)
        return tuple(
            Sighting(
                float(plant.log.t[k]), self._measured(plant, int(k)), self.sky.sun_N, deviation
            )
            for k in seen
        )

    def sees(self, plant: Plant, rows: Rows) -> NDArray[np.bool_]:
        """Whether a reading is due and the Sun stands in the field of view."""
        per_sample = self.sheet.rate_hz * self.tick
        due = np.floor(rows * per_sample + 1e-9) > np.floor((rows - 1) * per_sample + 1e-9)
        axis_N = rotation_matrix(plant.attitudes[rows]) @ unit(self.sheet.boresight)
        inside = angles(axis_N, self.sky.sun_N) <= math.radians(self.sheet.field_deg)
        return due & inside & self.sky.lit(plant.log.t[rows])

    def _measured(self, plant: Plant, row: int) -> Vector3:
        sun_B = rotation_matrix(plant.attitudes[row]).T @ self.sky.sun_N
        seen = sun_B + np.cross(self.error[row], sun_B)
        return seen / np.linalg.norm(seen)


def build_sun_sensor(
    sheet: SunSensorSheet, sky: Sky, rows: int, tick: float, rng: np.random.Generator
) -> SunSensor:
    """A sensor of this kind for a flight of so many samples, `tick` (s) apart."""
    error = math.radians(sheet.noise_deg) * rng.standard_normal((rows, 3))
    return SunSensor(sheet, sky, tick, error)
