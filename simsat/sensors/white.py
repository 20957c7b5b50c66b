"""White noise on the truth, a bias and a delay: the plainest instruments, at every sample."""

import math
from dataclasses import dataclass

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternion, Vector3
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.measurement import Fix
from simsat.mjcf.wheels import RPM
from simsat.plant.log import Samples
from simsat.plant.plant import Plant
from simsat.sensors.errors import Errors, ErrorTable
from simsat.sensors.settings import SensorSettings
from simsat.sensors.suite import Rows, Suite
from simsat.sensors.units import ARCSECOND, DEG_PER_HOUR, DEG_PER_ROOT_HOUR


@dataclass(frozen=True)
class WhiteNoise:
    """Instruments with their errors, one row per sample of the flight."""

    errors: ErrorTable
    delay: int
    attitude_noise: float
    """Standard deviation of the attitude about each axis, rad."""

    @property
    def suite(self) -> Suite:
        """What the loop senses with."""
        return Suite(self.rates, self.wheel_speeds, self, needs_all=False)

    def rates(self, plant: Plant, rows: Rows) -> Array:
        """Body rates at samples that follow each other, rad/s, shape (k, 3)."""
        past, seen = self._past(plant, rows)
        errors = self.errors.rows(int(rows[0]), int(rows[-1]))
        return past.omega[seen] * (1.0 + errors.relative[:, 3:6]) + errors.gyro

    def wheel_speeds(self, plant: Plant, rows: Rows) -> Array:
        """Wheel speeds likewise, rad/s, shape (k, m)."""
        past, seen = self._past(plant, rows)
        errors = self.errors.rows(int(rows[0]), int(rows[-1]))
        return past.wheel_speed[seen] * (1.0 + errors.relative[:, 6:]) + errors.wheel_speed

    def attitude(self, plant: Plant, row: int) -> Quaternion:
        """Body -> inertial."""
        past, seen = self._past(plant, np.array([row]))
        q, errors = past.q[seen[-1]], self.errors.rows(row, row)
        turn = errors.attitude[-1] + errors.relative[-1, :3] * attitude.rotation_vector(q)
        return _turned(q, turn)

    def fixes(self, plant: Plant, rows: Rows) -> tuple[Fix, ...]:
        """The newest attitude, with the noise that is stated; an estimator takes it for one of now,
        as the delay isn't told."""
        row = int(rows[-1])
        covariance = max(self.attitude_noise, ARCSECOND) ** 2 * np.eye(3)
        return (Fix(row * plant.tick, self.attitude(plant, row), covariance),)

    def _past(self, plant: Plant, rows: Rows) -> tuple[Samples, Rows]:
        """Samples of the truth, and which of them are told at these rows."""
        past = plant.recent(plant.sampled - int(rows[0]) + self.delay)
        return past, np.maximum(rows - self.delay, 0) - (plant.sampled - len(past.t))


def build_white_noise(settings: SensorSettings, rows: int, tick: float, wheels: int) -> WhiteNoise:
    """White-noise instruments for a flight of so many samples, `tick` (s) apart.

    Raises `SettingsError` on a delay longer than the flight.
    """
    if settings.delay_samples >= rows:
        raise SettingsError(
            f"--sensors.delay-samples is {settings.delay_samples}, the whole flight has {rows}"
        )
    rng = np.random.default_rng(settings.seed)
    bias = settings.gyro_bias_deg_h * DEG_PER_HOUR * rng.standard_normal(3)
    # White rate noise of density N sampled every tick: N / sqrt(tick) (IEEE Std 952, annex C).
    walk = settings.gyro_random_walk_deg_sqrt_h * DEG_PER_ROOT_HOUR / math.sqrt(tick)
    attitude_noise = settings.attitude_noise_arcsec * ARCSECOND

    def draw(rng: np.random.Generator, k: int) -> Errors:
        return Errors(
            attitude=attitude_noise * rng.standard_normal((k, 3)),
            gyro=bias + walk * rng.standard_normal((k, 3)),
            wheel_speed=settings.wheel_speed_noise_rpm * RPM * rng.standard_normal((k, wheels)),
            relative=(
                settings.relative_noise_percent / 100.0 * rng.standard_normal((k, 6 + wheels))
            ),
        )

    table = ErrorTable(draw, rng, rows, settings.seed)
    return WhiteNoise(table, settings.delay_samples, attitude_noise)


def _turned(q: Array, turn: Vector3) -> Array:
    """q turned by a small rotation vector (rad) in body axes."""
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return q.copy()
    return attitude.multiply(q, attitude.from_axis_angle(turn, angle))
