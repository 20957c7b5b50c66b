"""The magnetic field as the craft knows it, added to what is sensed: a model, or a magnetometer.

A model on board knows the orbit and the time; the attitude, which turns it into body axes, only as
well as it is sensed. A magnetometer is blind while rods are on, whose field at its place is far
above the Earth's: they rest at the end of each control period so that it sees something.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Vector3, WheelVector
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import Bounds, Settings
from simsat.control.interface.measurement import Measurement
from simsat.environment import Environment
from simsat.environment.environment import build_field
from simsat.environment.fields.field import MagneticField
from simsat.flight.loop import Sense
from simsat.plant.plant import Plant
from simsat.sensors.settings import SensorSettings

NO_BIAS: Vector3 = np.array([0.0, 0.0, 0.0])
NANOTESLA = 1e-9  # T
STREAM = 1  # of random numbers: the magnetometer's own, whatever else is drawn


@dataclass(frozen=True)
class OnboardSettings(Settings, group="onboard"):
    """What the craft knows of its surroundings."""

    field: Literal["same", "dipole", "igrf", "magnetometer"] = "same"
    """Where the controller has the magnetic field from: the model that the plant flies by
    (--environment.field), one of its own, or a magnetometer."""
    quiet_samples: Annotated[int, Bounds(0)] = 2
    """Samples at the end of each control period in which rods are off for the magnetometer: 2 of 10
    leave them four fifths of their dipole in the mean."""


@dataclass(frozen=True)
class WithFieldModel:
    """Adds the field of a model on board."""

    sense: Sense
    model: MagneticField

    def __call__(self, plant: Plant, samples: int, torque: WheelVector) -> Measurement:
        """The measurement with the field."""
        sensed = self.sense(plant, samples, torque)
        R = attitude.rotation_matrix(sensed.q)
        return replace(sensed, field_B=R.T @ np.array(self.model(float(sensed.t))))


@dataclass(frozen=True)
class WithMagnetometer:
    """Adds what a magnetometer reads, or nothing where rods were on."""

    sense: Sense
    field: MagneticField
    """As it is."""
    bias: Vector3
    """T, body axes."""
    noise: float
    """Standard deviation about each axis, T."""
    delay: int
    """Age of what is read, in samples."""
    seed: int

    def __call__(self, plant: Plant, samples: int, torque: WheelVector) -> Measurement:
        """The measurement with the field, if it could be read."""
        sensed = self.sense(plant, samples, torque)
        newest = plant.sampled - 1
        past = plant.recent(self.delay + 1)  # at the start as many as there are
        if past.dipole[0].any():
            return sensed
        R = attitude.rotation_matrix(past.q[0])
        error = self.noise * np.random.default_rng((self.seed, STREAM, newest)).standard_normal(3)
        field_B = R.T @ np.array(self.field(float(past.t[0]))) + self.bias + error
        return replace(sensed, field_B=field_B)


def know_field(
    sense: Sense, settings: OnboardSettings, sensors: SensorSettings, environment: Environment
) -> Sense:
    """What the loop senses with, and the field as it is known.

    Raises `SettingsError` if a model on board doesn't cover the epoch.
    """
    if settings.field == "same":
        return WithFieldModel(sense, environment.field)
    if settings.field != "magnetometer":
        return WithFieldModel(sense, build_field(settings.field, environment.orbit))
    if not sensors.noisy:
        return WithMagnetometer(sense, environment.field, NO_BIAS, 0.0, 0, 0)
    rng = np.random.default_rng((sensors.seed, STREAM))
    return WithMagnetometer(
        sense,
        environment.field,
        bias=sensors.magnetometer_bias_nT * NANOTESLA * rng.standard_normal(3),
        noise=sensors.magnetometer_noise_nT * NANOTESLA,
        delay=sensors.delay_samples if sensors.enabled else 0,
        seed=sensors.seed,
    )


def quiet_ticks(settings: OnboardSettings, ticks_per_period: int) -> int:
    """Ticks at the end of each period in which rods are off.

    Raises `SettingsError` if they would never be on.
    """
    if settings.field != "magnetometer":
        return 0
    if settings.quiet_samples >= ticks_per_period:
        raise SettingsError(
            f"--onboard.quiet-samples is {settings.quiet_samples}: a control period has "
            f"{ticks_per_period} samples, and rods must be on in some"
        )
    return settings.quiet_samples
