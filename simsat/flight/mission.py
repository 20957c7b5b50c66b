"""From settings to a flight: the one place where plant, environment and controller meet."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from simsat.control.ground.arrays import Quaternion, Vector3, WheelVector
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft, nominal
from simsat.control.interface.foresight import Foresight
from simsat.control.interface.layers import Pilot
from simsat.environment import Environment, build_environment
from simsat.environment.own import OwnTorque
from simsat.faults.damage import plant_events
from simsat.faults.fault import Fault, read_faults
from simsat.faults.senses import faulty
from simsat.flight.controllers import Brief, build_pilot, monitored
from simsat.flight.estimators import build_estimator
from simsat.flight.loop import Flight, Sense, Watch, fly, sense_truth
from simsat.flight.onboard_field import WithFieldModel
from simsat.flight.own_controller import own_pilot
from simsat.flight.plugins import is_plugin, load
from simsat.mjcf import Model, read_model
from simsat.mjcf.shipped import find_model
from simsat.mjcf.wheels import RPM
from simsat.plant.plant import Plant, whole_steps
from simsat.sensors.build import Span, build_suite
from simsat.sensors.truth import TRUTH
from simsat.settings import FlightSettings, StartSettings


@dataclass(frozen=True)
class Plugins:
    """Code of the user's own in a flight; `plugins_of` loads what settings name."""

    controller: Callable[..., Any] | None = None
    """Called with the `Brief` (see `own_controller`)."""
    network: Callable[..., Any] | None = None
    """Called with the `Brief` (see `own_estimator`)."""
    torques: Mapping[str, OwnTorque] = field(default_factory=dict)
    metrics: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    """Called with the flown flight (see `results.flight_result`)."""


@dataclass(frozen=True)
class State:
    """Attitude and rates of a spacecraft, to start from."""

    q: Quaternion
    omega: Vector3
    """Body axes, rad/s."""
    wheel_speed: WheelVector
    """Relative to the hub, rad/s."""


@dataclass(frozen=True)
class Mission:
    """A flight ready to go, as often as one likes."""

    settings: FlightSettings
    model: Model
    believed: Spacecraft
    environment: Environment
    pilot: Pilot | None
    """None when nobody flies it: a profile is replayed (see `replay`)."""
    periods: int
    ticks_per_period: int
    start: State
    sense: Sense = sense_truth
    faults: tuple[Fault, ...] = ()
    plugins: Plugins = field(default_factory=Plugins)

    @property
    def sees_truth(self) -> bool:
        """Whether the controller is shown the state as it is."""
        inner = self.sense.sense if isinstance(self.sense, WithFieldModel) else self.sense
        return inner is sense_truth

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
        return self.periods * self.ticks_per_period * self.settings.sample_s

    def build_plant(self) -> Plant:
        """The spacecraft in MuJoCo, at its start."""
        plant = Plant(
            self.model,
            self.settings.sample_s,
            self.periods * self.ticks_per_period,
            self.environment.torque if self.environment.models else None,
            self.environment.field,
            plant_events(self.faults, self.model, self.settings.sample_s),
        )
        plant.reset(self.start.q, self.start.omega, self.start.wheel_speed)
        return plant

    def fly(self, watch: Watch = lambda flight: None) -> Flight:
        """Fly it from its start; a controller of the user's own is made anew for each flight, so
        that it remembers nothing of the last one."""
        pilot = self.pilot if self.plugins.controller is None else _pilot(self.brief, self.plugins)
        assert pilot is not None
        plant = self.build_plant()
        ticks, delay = self.ticks_per_period, self.settings.delay.samples(self.settings.sample_s)
        return fly(plant, pilot, self.periods, ticks, self.sense, watch, delay)

    @property
    def brief(self) -> Brief:
        """What its controller is built from."""
        return Brief(
            self.believed,
            self.settings,
            self.target,
            self.model.spacecraft,
            self.environment,
            self.plugins.network,
        )


def prepare(
    settings: FlightSettings, model: Model | None = None, plugins: Plugins | None = None
) -> Mission:
    """Read the model, build environment and controller.

    A `model` given takes the place of the file that the settings name, and `plugins` that of the
    code they name. Raises `ModelError`, `SettingsError` or `PluginError` with one sentence on bad
    input.
    """
    period = settings.nmpc.period
    periods = whole_steps(settings.duration_s, period, "flight of --duration-s")
    ticks = whole_steps(period, settings.sample_s, "control period --nmpc.period in --sample-s")
    plugins = plugins_of(settings) if plugins is None else plugins
    model = read_model(find_model(settings.model)) if model is None else model
    craft = model.spacecraft
    believed = _believed(craft, settings)
    environment = build_environment(craft, settings.orbit, settings.environment, plugins.torques)
    whole_steps(settings.sample_s, float(model.mj.opt.timestep), "sample interval")
    brief = Brief(believed, settings, settings.q_target, craft, environment, plugins.network)
    faults = read_faults(settings.fault, craft)
    plant_events(faults, model, settings.sample_s)  # refuses what no plant can do
    return Mission(
        settings=settings,
        model=model,
        believed=believed,
        environment=environment,
        pilot=_pilot(brief, plugins),
        periods=periods,
        ticks_per_period=ticks,
        start=State(settings.q_start, *_motion(craft, settings.start)),
        sense=mission_sense(settings, faults, craft, environment),
        faults=faults,
        plugins=plugins,
    )


def mission_sense(
    settings: FlightSettings,
    faults: tuple[Fault, ...],
    craft: Spacecraft,
    environment: Environment,
) -> Sense:
    """What the loop senses with: the truth or instruments, with their faults, and the magnetic
    field as known on board."""
    rows = whole_steps(settings.duration_s, settings.sample_s, "flight of --duration-s") + 1
    span = Span(rows, settings.sample_s, craft.wheels, environment.orbit)
    suite = faulty(build_suite(settings.sensors, span), faults, craft, settings.sample_s)
    return WithFieldModel(sense_truth if suite is TRUTH else suite, environment.field)


def plugins_of(settings: FlightSettings) -> Plugins:
    """The code of the user's own that settings name. Raises `PluginError` if it isn't there."""
    controller, network = settings.controller, settings.network
    return Plugins(
        controller=load(controller, "--controller") if is_plugin(controller) else None,
        network=load(network, "--network") if is_plugin(network) else None,
        torques={name: load(name, "--torque") for name in settings.torque},
        metrics={name: load(name, "--metric") for name in settings.metric},
    )


def _pilot(brief: Brief, plugins: Plugins) -> Pilot:
    settings = brief.settings
    if plugins.controller is None:
        pilot = build_pilot(brief)
    else:
        pilot = own_pilot(plugins.controller, settings.controller, brief, brief.truth)
    if settings.reconfigure:
        pilot = monitored(pilot, brief)
    estimator = build_estimator(settings.estimator, settings.sensors, settings.sample_s)
    pilot = pilot if estimator is None else replace(pilot, estimator=estimator)
    if settings.delay.foresight and settings.delay.samples(settings.sample_s):
        pilot = replace(pilot, foresight=Foresight(brief.nominal))
    return pilot


def _believed(craft: Spacecraft, settings: FlightSettings) -> Spacecraft:
    """What the controller believes; refused where no body has such an inertia."""
    mismatch = settings.nominal.mismatch
    believed = nominal(craft, settings.nominal.inertia_factors, mismatch)
    least = np.linalg.eigvalsh(believed.J)[0]
    if not least > 0.0:
        raise SettingsError(
            f"--nominal.mismatch {mismatch:g} makes a principal moment of the believed inertia "
            f"{least:g} kg m^2; all must be above zero"
        )
    return believed


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
