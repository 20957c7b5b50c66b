"""What the instruments make of the truth: noise, bias and delay. Metrics always judge the truth.

The default figures are a small satellite's class of instruments: a star tracker of 10 arcseconds
(Blue Canyon NST: 6 across the boresight, 40 about it), a tactical MEMS gyro (Sensonor STIM210:
angle random walk 0.15 deg/sqrt(h), bias 0.3 deg/h), wheel tachometers of 1 rpm (assumed), a
magnetometer of 20 nT (NewSpace Systems NMRM: 16) with 100 nT left after calibration (assumed), and
one sample of delay for reading them all (assumed).
"""

import math
from dataclasses import dataclass

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Vector3, WheelVector
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import CountOrNone, NotNegative, Settings
from simsat.control.interface.measurement import History, Measurement
from simsat.flight.loop import Sense, sense_truth
from simsat.flight.sensor_errors import Errors, ErrorTable
from simsat.mjcf.wheels import RPM
from simsat.plant.plant import Plant

ARCSECOND = math.radians(1.0 / 3600.0)
DEG_PER_HOUR = math.radians(1.0) / 3600.0
DEG_PER_ROOT_HOUR = math.radians(1.0) / 60.0  # in rad/sqrt(s)


@dataclass(frozen=True)
class SensorSettings(Settings, group="sensors"):
    """What the controller sees: the truth, or instruments."""

    enabled: bool = False
    """Show the controller instruments instead of the truth."""
    attitude_noise_arcsec: NotNegative = 10.0
    """Standard deviation of the attitude about each body axis, arcseconds."""
    gyro_random_walk_deg_sqrt_h: NotNegative = 0.15
    """Angle random walk of the gyro, deg/sqrt(h): white noise on the rate, 0.011 deg/s at 20 Hz."""
    gyro_bias_deg_h: NotNegative = 0.3
    """Standard deviation of the gyro's bias, deg/h: drawn once per flight and axis."""
    wheel_speed_noise_rpm: NotNegative = 1.0
    """Standard deviation of each wheel's speed, rpm."""
    magnetometer_noise_nT: NotNegative = 20.0
    """Standard deviation of the magnetic field about each body axis, nT, where --onboard.field is
    magnetometer."""
    magnetometer_bias_nT: NotNegative = 100.0
    """Standard deviation of the magnetometer's bias, nT: drawn once per flight and axis."""
    relative_noise_percent: NotNegative = 0.0
    """Further noise on every quantity, percent of its own size: attitude (its rotation from the
    inertial axes), rates, wheel speeds."""
    delay_samples: CountOrNone = 1
    """Age of what the controller sees, in samples; it isn't told."""
    seed: CountOrNone = 0
    """Seed of all noise: the same seed gives the same flight."""


@dataclass(frozen=True)
class Instruments:
    """Instruments with their errors, one row per sample of the flight."""

    errors: ErrorTable
    delay: int

    def __call__(self, plant: Plant, samples: int, torque: WheelVector) -> Measurement:
        """The measurement at the plant's newest sample, with those since the last instant."""
        newest = plant.sampled - 1
        rows = np.arange(newest - samples, newest + 1)
        errors = self.errors.rows(newest - samples, newest)
        past = plant.recent(samples + 1 + self.delay)
        seen = np.maximum(rows - self.delay, 0) - (newest + 1 - len(past.t))
        share = errors.relative
        omega = past.omega[seen] * (1.0 + share[:, 3:6]) + errors.gyro
        speed = past.wheel_speed[seen] * (1.0 + share[:, 6:]) + errors.wheel_speed
        q = past.q[seen[-1]]
        turn = errors.attitude[-1] + share[-1, :3] * attitude.rotation_vector(q)
        t = past.t[-(samples + 1) :]
        history = History(t, omega, speed)
        return Measurement(
            t[-1], _turned(q, turn), omega[-1], speed[-1], torque, history, plant.commanded_dipole
        )


def build_sense(settings: SensorSettings, rows: int, tick: float, wheels: int) -> Sense:
    """What the loop senses with on a flight of so many samples, `tick` (s) apart.

    Raises `SettingsError` on a delay longer than the flight.
    """
    if not settings.enabled:
        return sense_truth
    if settings.delay_samples >= rows:
        raise SettingsError(
            f"--sensors.delay-samples is {settings.delay_samples}, the whole flight has {rows}"
        )
    rng = np.random.default_rng(settings.seed)
    bias = settings.gyro_bias_deg_h * DEG_PER_HOUR * rng.standard_normal(3)
    # White rate noise of density N sampled every tick: N / sqrt(tick) (IEEE Std 952, annex C).
    walk = settings.gyro_random_walk_deg_sqrt_h * DEG_PER_ROOT_HOUR / math.sqrt(tick)

    def draw(rng: np.random.Generator, k: int) -> Errors:
        return Errors(
            attitude=settings.attitude_noise_arcsec * ARCSECOND * rng.standard_normal((k, 3)),
            gyro=bias + walk * rng.standard_normal((k, 3)),
            wheel_speed=settings.wheel_speed_noise_rpm * RPM * rng.standard_normal((k, wheels)),
            relative=(
                settings.relative_noise_percent / 100.0 * rng.standard_normal((k, 6 + wheels))
            ),
        )

    return Instruments(ErrorTable(draw, rng, rows, settings.seed), settings.delay_samples)


def _turned(q: Array, turn: Vector3) -> Array:
    """q turned by a small rotation vector (rad) in body axes."""
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return q.copy()
    return attitude.multiply(q, attitude.from_axis_angle(turn, angle))
