"""Where Sun and Earth stand, seen from the spacecraft."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simsat.control.ground.arrays import Array, Vector3
from simsat.environment.earth import RADIUS, sun_direction
from simsat.environment.orbit import Centre, Orbit
from simsat.environment.solar_pressure import sunlit


@dataclass(frozen=True)
class Sky:
    """The Sun stands still at its place at t = 0 (0.04 degrees an hour)."""

    orbit: Orbit

    @property
    def sun_N(self) -> Vector3:
        """Unit vector to the Sun, inertial axes."""
        if self.orbit.centre is Centre.SUN:
            return -np.array(self.orbit.direction(0.0))
        return np.array(sun_direction(self.orbit.epoch_days))

    def from_limb(self, direction_N: Array, t: Array) -> Array:
        """Angles from the Earth's limb to directions, shape (k, 3), at times t, rad; far from it on
        an orbit around the Sun."""
        if self.orbit.centre is Centre.SUN:
            return np.full(len(t), np.pi)
        half = np.arcsin(RADIUS / np.asarray(self.orbit.radius_at(t), float))
        return angles(direction_N, self.nadir_N(t)) - half

    def nadir_N(self, t: Array) -> Array:
        """Unit vectors to the centre of the orbit, inertial axes, shape (k, 3)."""
        return -np.stack(np.broadcast_arrays(*self.orbit.direction(t)), axis=-1)

    def lit(self, t: Array) -> NDArray[np.bool_]:
        """Whether the Sun is seen, shape (k,)."""
        if self.orbit.centre is Centre.SUN:
            return np.full(len(t), True)
        sun = sun_direction(self.orbit.epoch_days)
        return np.asarray(sunlit(self.orbit.direction(t), sun, self.orbit.radius_at(t))) > 0.5


def angles(a: Array, b: Array) -> Array:
    """Angles between unit vectors, rad, over the last axis."""
    return np.arccos(np.clip(np.sum(a * b, axis=-1), -1.0, 1.0))


def unit(axis: tuple[float, float, float]) -> Vector3:
    """A unit vector along an axis of any length."""
    vector = np.array(axis)
    return vector / np.linalg.norm(vector)
