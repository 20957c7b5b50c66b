"""Where Sun and Earth stand, seen from the spacecraft."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simsat.control.ground.arrays import Array, Vector3
from simsat.environment.earth import RADIUS, sun_direction
from simsat.environment.orbit import Orbit
from simsat.environment.solar_pressure import sunlit


@dataclass(frozen=True)
class Sky:
    """The Sun stands still at its place at t = 0 (0.04 degrees an hour)."""

    orbit: Orbit

    @property
    def sun_N(self) -> Vector3:
        """Unit vector to the Sun, inertial axes."""
        return np.array(sun_direction(self.orbit.epoch_days))

    @property
    def earth_radius_rad(self) -> float:
        """Angle between the Earth's centre and its limb."""
        return math.asin(RADIUS / self.orbit.radius)

    def nadir_N(self, t: Array) -> Array:
        """Unit vectors to the Earth's centre, inertial axes, shape (k, 3)."""
        return -np.stack(self.orbit.direction(t), axis=-1)

    def lit(self, t: Array) -> NDArray[np.bool_]:
        """Whether the Sun is seen, shape (k,)."""
        up = self.orbit.direction(t)
        return np.asarray(sunlit(up, sun_direction(self.orbit.epoch_days), self.orbit.radius)) > 0.5


def angles(a: Array, b: Array) -> Array:
    """Angles between unit vectors, rad, over the last axis."""
    return np.arccos(np.clip(np.sum(a * b, axis=-1), -1.0, 1.0))


def unit(axis: tuple[float, float, float]) -> Vector3:
    """A unit vector along an axis of any length."""
    vector = np.array(axis)
    return vector / np.linalg.norm(vector)
