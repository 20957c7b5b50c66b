"""White noise on the truth, a bias and a delay: the plainest instruments, at every sample."""

import math
from dataclasses import dataclass

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Quaternion, Vector3
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.measurement import Fix
from simsat.mjcf.wheels import RPM
from simsat.plant.plant import Plant
from simsat.sensors.settings import SensorSettings
from simsat.sensors.suite import Rows, Suite
from simsat.sensors.units import ARCSECOND, DEG_PER_HOUR, DEG_PER_ROOT_HOUR


@dataclass(frozen=True)
class WhiteNoise:
    """Errors drawn beforehand: one row per sample of the flight."""

    attitude_error: Array
    """Small rotation in body axes, rad, shape (rows, 3)."""
    gyro_error: Array
    """rad/s, shape (rows, 3)."""
    wheel_speed_error: Array
    """rad/s, shape (rows, m)."""
    relative_error: Array
    """Factors on attitude, rate and wheel speeds less one, shape (rows, 6 + m)."""
    delay: int

    @property
    def suite(self) -> Suite:
        """What the loop senses with."""
        return Suite(self.rates, self.wheel_speeds, self)

    def rates(self, plant: Plant, rows: Rows) -> Array:
        """Body rates, rad/s, shape (k, 3)."""
        share = self.relative_error[rows, 3:6]
        return plant.rates[self._seen(rows)] * (1.0 + share) + self.gyro_error[rows]

    def wheel_speeds(self, plant: Plant, rows: Rows) -> Array:
        """Wheel speeds, rad/s, shape (k, m)."""
        share = self.relative_error[rows, 6:]
        return plant.wheel_speeds[self._seen(rows)] * (1.0 + share) + self.wheel_speed_error[rows]

    def attitude(self, plant: Plant, row: int) -> Quaternion:
        """Body -> inertial."""
        q = plant.attitudes[max(row - self.delay, 0)]
        share = self.relative_error[row, :3]
        return _turned(q, self.attitude_error[row] + share * attitude.rotation_vector(q))

    def fixes(self, plant: Plant, rows: Rows) -> tuple[Fix, ...]:
        """The newest attitude, with the noise that is stated; an estimator takes it for one of now,
        as the delay isn't told."""
        row = int(rows[-1])
        covariance = np.eye(3) * max(float(np.mean(self.attitude_error**2)), ARCSECOND**2)
        return (Fix(float(plant.log.t[row]), self.attitude(plant, row), covariance),)

    def _seen(self, rows: Rows) -> Rows:
        return np.maximum(rows - self.delay, 0)


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
    return WhiteNoise(
        attitude_error=settings.attitude_noise_arcsec * ARCSECOND * rng.standard_normal((rows, 3)),
        gyro_error=bias + walk * rng.standard_normal((rows, 3)),
        wheel_speed_error=(
            settings.wheel_speed_noise_rpm * RPM * rng.standard_normal((rows, wheels))
        ),
        relative_error=(
            settings.relative_noise_percent / 100.0 * rng.standard_normal((rows, 6 + wheels))
        ),
        delay=settings.delay_samples,
    )


def _turned(q: Array, turn: Vector3) -> Array:
    """q turned by a small rotation vector (rad) in body axes."""
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return q.copy()
    return attitude.multiply(q, attitude.from_axis_angle(turn, angle))
