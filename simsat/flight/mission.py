"""From settings to a flight: the one place where plant, environment and controller meet."""

from dataclasses import dataclass

import numpy as np

from simsat.control.ground.arrays import Quaternion, Vector3, WheelVector
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft, nominal
from simsat.control.interface.layers import Pilot
from simsat.environment import Environment, build_environment
from simsat.flight.controllers import Brief, build_pilot
from simsat.flight.loop import Flight, Sense, Watch, fly, sense_truth
from simsat.flight.sensors import build_sense
from simsat.mjcf import Model, read_model
from simsat.mjcf.wheels import RPM
from simsat.plant.plant import Plant, whole_steps
from simsat.settings import FlightSettings, StartSettings, find_model


@dataclass(frozen=True)
class Mission:
    """A flight ready to go."""

    settings: FlightSettings
    model: Model
    believed: Spacecraft
    environment: Environment
    plant: Plant
    pilot: Pilot | None
    """None when nobody flies it: a profile is replayed (see `replay`)."""
    periods: int
    ticks_per_period: int
    sense: Sense = sense_truth

    @property
    def target(self) -> Quaternion:
        """The reference attitude."""
        return self.settings.q_target

    @property
    def title(self) -> str:
        """One line for pictures and recordings: craft, controller, manoeuvre."""
        s = self.settings
        axis = ", ".join(f"{part:.2f}" for part in s.axis)
        return f"{self.model.spacecraft.name}, {s.controller}: {s.angle_deg:g} deg about ({axis})"

    @property
    def duration_s(self) -> float:
        """Length of the flight, s."""
        return self.periods * self.ticks_per_period * self.plant.tick

    def fly(self, watch: Watch = lambda flight: None) -> Flight:
        """Fly it."""
        assert self.pilot is not None
        return fly(self.plant, self.pilot, self.periods, self.ticks_per_period, self.sense, watch)


def prepare(settings: FlightSettings) -> Mission:
    """Read the model, build plant, environment and controller, and put the craft at its start.

    Raises `ModelError` or `SettingsError` with one sentence on bad input.
    """
    period = settings.nmpc.period
    periods = whole_steps(settings.duration_s, period, "flight of --duration-s")
    ticks = whole_steps(period, settings.sample_s, "control period --nmpc.period in --sample-s")
    model = read_model(find_model(settings.model))
    craft = model.spacecraft
    believed = _believed(craft, settings)
    environment = build_environment(craft, settings.orbit, settings.environment)
    plant = Plant(
        model,
        settings.sample_s,
        periods * ticks,
        environment.torque if environment.models else None,
    )
    plant.reset(settings.q_start, *_motion(craft, settings.start))
    brief = Brief(believed, settings, settings.q_target, craft, environment)
    pilot = build_pilot(brief)
    sense = build_sense(settings.sensors, periods * ticks + 1, settings.sample_s, craft.wheels)
    return Mission(settings, model, believed, environment, plant, pilot, periods, ticks, sense)


def _believed(craft: Spacecraft, settings: FlightSettings) -> Spacecraft:
    """What the controller believes; refused where no body has such an inertia."""
    mismatch = settings.nominal.mismatch
    believed = nominal(craft, _factors(settings), mismatch)
    least = np.linalg.eigvalsh(believed.J)[0]
    if not least > 0.0:
        raise SettingsError(
            f"--nominal.mismatch {mismatch:g} makes a principal moment of the believed inertia "
            f"{least:g} kg m^2; all must be above zero"
        )
    return believed


def _factors(settings: FlightSettings) -> Vector3 | None:
    factors = settings.nominal.inertia_factors
    return None if factors is None else np.array(factors)


def _motion(craft: Spacecraft, start: StartSettings) -> tuple[Vector3, WheelVector]:
    """Body rates and wheel speeds at the start, rad/s."""
    omega = np.radians(start.omega_deg_s)
    speed = RPM * np.array(start.wheel_speed_rpm or np.zeros(craft.wheels), float)
    if len(speed) != craft.wheels:
        raise SettingsError(
            f"--start.wheel-speed-rpm has {len(speed)} numbers, "
            f"but '{craft.name}' has {craft.wheels} wheels ({', '.join(craft.wheel_names)})"
        )
    if start.zero_momentum:
        if start.wheel_speed_rpm:
            raise SettingsError(
                "--start.zero-momentum chooses the wheel speeds: leave out --start.wheel-speed-rpm"
            )
        speed = -np.linalg.pinv(craft.A * craft.Js) @ (craft.J @ omega)
    if not np.all(np.abs(speed) <= craft.speed_max * (1.0 + 1e-9)):
        raise SettingsError(
            f"--start gives the wheels {_rpm(speed)} rpm, their limits are {_rpm(craft.speed_max)}"
        )
    return omega, speed


def _rpm(speeds: WheelVector) -> str:
    return ", ".join(f"{speed:.5g}" for speed in speeds / RPM)
