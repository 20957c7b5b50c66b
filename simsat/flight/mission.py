"""From settings to a flight: the one place where plant, environment and controller meet."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Quaternion, Quaternions, Vector3, WheelVector
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.own import numbers
from simsat.control.ground.spacecraft import Spacecraft, nominal, with_rods_on_for
from simsat.control.interface.foresight import Foresight
from simsat.control.interface.layers import Pilot
from simsat.control.reference.reference import Reference
from simsat.environment import Environment, build_environment
from simsat.environment.own import OwnTorque
from simsat.faults.damage import plant_events
from simsat.faults.fault import Fault, read_faults
from simsat.faults.senses import faulty
from simsat.flight.controllers import Brief, build_pilot
from simsat.flight.estimators import build_estimator
from simsat.flight.loop import Flight, Sense, Watch, fly, sense_truth
from simsat.flight.onboard_field import know_field, quiet_ticks
from simsat.flight.own_controller import own_pilot
from simsat.flight.plugins import is_plugin, load
from simsat.flight.timing import Timing, timing_of, with_timing
from simsat.mjcf import Model, read_model
from simsat.mjcf.shipped import find_model
from simsat.mjcf.wheels import RPM
from simsat.plant.log import WINDOW
from simsat.plant.plant import Plant, whole_steps
from simsat.reference.build import build_reference
from simsat.reference.demand import refuse_too_fast
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
    """As they were given; `brief` has them with a number for what wasn't."""
    model: Model
    believed: Spacecraft
    environment: Environment
    pilot: Pilot | None
    """None when nobody flies it: a profile is replayed (see `replay`)."""
    timing: Timing
    start: State
    reference: Reference
    sense: Sense = sense_truth
    faults: tuple[Fault, ...] = ()
    plugins: Plugins = field(default_factory=Plugins)

    @property
    def sees_truth(self) -> bool:
        """Whether the controller is shown the state as it is."""
        return getattr(self.sense, "sense", self.sense) is sense_truth

    @property
    def target(self) -> Quaternion:
        """The reference attitude at the start."""
        return self.reference.attitude(0.0)

    def references(self, flight: Flight) -> Quaternions:
        """The reference attitude at every sample that the flight's log keeps, shape (rows, 4)."""
        return self.reference.attitude(flight.plant.log.t)

    @property
    def keep_ticks(self) -> int:
        """Every how many samples the log keeps one."""
        return _keep_ticks(self.settings, self.timing)

    @property
    def quiet_ticks(self) -> int:
        """Samples at the end of each control period in which rods are off for the magnetometer."""
        return quiet_ticks(self.settings.onboard, self.ticks_per_period)

    @property
    def title(self) -> str:
        """One line for pictures and recordings: craft, controller, manoeuvre."""
        s = self.settings
        axis = ", ".join(f"{part:.2f}" for part in s.axis)
        return f"{self.model.spacecraft.name}, {s.controller}: {s.angle_deg:g} deg about ({axis})"

    @property
    def duration_s(self) -> float:
        """Length of the flight, s."""
        return self.timing.duration_s

    @property
    def periods(self) -> int:
        """Control periods in the flight."""
        return self.timing.periods

    @property
    def ticks_per_period(self) -> int:
        """Samples in a control period."""
        return self.timing.ticks_per_period

    def build_plant(self) -> Plant:
        """The spacecraft in MuJoCo, at its start."""
        plant = Plant(
            self.model,
            self.timing.sample_s,
            self.timing.samples,
            self.environment.torque if self.environment.models else None,
            self.environment.field,
            self.keep_ticks,
            plant_events(self.faults, self.model, self.timing.sample_s),
        )
        plant.reset(self.start.q, self.start.omega, self.start.wheel_speed)
        return plant

    def fly(self, watch: Watch = lambda flight: None) -> Flight:
        """Fly it from its start; a controller of the user's own is made anew for each flight, so
        that it remembers nothing of the last one."""
        pilot = self.pilot if self.plugins.controller is None else self._own_pilot()
        assert pilot is not None
        plant = self.build_plant()
        ticks, quiet = self.ticks_per_period, self.quiet_ticks
        delay = self.settings.delay.samples(self.timing.sample_s)
        return fly(plant, pilot, self.periods, ticks, self.sense, watch, quiet, delay)

    def _own_pilot(self) -> Pilot:
        return _pilot(self.brief, self.plugins, self.timing)

    @property
    def came_to(self) -> dict[str, float | None]:
        """What the settings in the craft's own units came to in SI, by dotted name."""
        return numbers(self.brief.settings)

    @property
    def brief(self) -> Brief:
        """What its controller is built from."""
        settings = with_timing(without_drift(self.settings, self.believed), self.timing)
        return Brief(
            self.believed,
            settings,
            self.target,
            self.model.spacecraft,
            self.environment,
            self.reference,
            self.plugins.network,
        )


def without_drift(settings: FlightSettings, craft: Spacecraft) -> FlightSettings:
    """The settings with no drift to prepare a hold for where rods take it, unless one is given."""
    if not (settings.rods.enabled and craft.rods.count and settings.learned.hold_s is None):
        return settings
    return replace(settings, learned=replace(settings.learned, hold_s=0.0))


def prepare(
    settings: FlightSettings, model: Model | None = None, plugins: Plugins | None = None
) -> Mission:
    """Read the model, build environment and controller.

    A `model` given takes the place of the file that the settings name, and `plugins` that of the
    code they name. Raises `ModelError`, `SettingsError` or `PluginError` with one sentence on bad
    input.
    """
    plugins = plugins_of(settings) if plugins is None else plugins
    model = read_model(find_model(settings.model)) if model is None else model
    craft, timing = model.spacecraft, timing_of(settings, model)
    _keep_ticks(settings, timing)
    ticks = timing.ticks_per_period
    rods_on = 1.0 - quiet_ticks(settings.onboard, ticks) / ticks
    believed = with_rods_on_for(rods_on, _believed(craft, settings))
    environment = build_environment(craft, settings.orbit, settings.environment, plugins.torques)
    reference = build_reference(
        settings.reference,
        settings.q_target,
        environment.orbit,
        settings.orbit.epoch_utc,
        timing.duration_s,
    )
    refuse_too_fast(reference, craft, timing.duration_s)
    q_start = attitude.multiply(reference.attitude(0.0), settings.turn)
    faults = read_faults(settings.fault, craft)
    plant_events(faults, model, timing.sample_s)  # refuses what no plant can do
    mission = Mission(
        settings=settings,
        model=model,
        believed=believed,
        environment=environment,
        pilot=None,
        timing=timing,
        start=State(q_start, *_motion(craft, settings.start)),
        reference=reference,
        sense=mission_sense(settings, timing, faults, craft, environment),
        faults=faults,
        plugins=plugins,
    )
    return replace(mission, pilot=_pilot(mission.brief, plugins, timing))


def _keep_ticks(settings: FlightSettings, timing: Timing) -> int:
    """Every how many samples the log keeps one. Raises `SettingsError` if that is no number."""
    if settings.keep_s is None:
        return 1
    keep = whole_steps(settings.keep_s, timing.sample_s, "--keep-s in --sample-s")
    at_hand = timing.ticks_per_period + settings.sensors.delay_samples
    if keep > 1 and at_hand > WINDOW // 2 - 2:
        raise SettingsError(
            f"--keep-s keeps {WINDOW // 2} samples at hand, a control period and the sensors' "
            f"delay have {at_hand:g}: leave out --keep-s"
        )
    return keep


def mission_sense(
    settings: FlightSettings,
    timing: Timing,
    faults: tuple[Fault, ...],
    craft: Spacecraft,
    environment: Environment,
) -> Sense:
    """What the loop senses with: the truth or instruments, with their faults, and the magnetic
    field as known on board."""
    span = Span(timing.samples + 1, timing.sample_s, craft.wheels, environment.orbit)
    suite = faulty(build_suite(settings.sensors, span), faults, craft, timing.sample_s)
    if settings.keep_s is not None and suite.needs_all:
        raise SettingsError(
            "--keep-s drops samples that instruments of a data sheet and their faults look back "
            "to: leave it out"
        )
    sense = sense_truth if suite is TRUTH else suite
    return know_field(sense, settings.onboard, settings.sensors, environment)


def plugins_of(settings: FlightSettings) -> Plugins:
    """The code of the user's own that settings name. Raises `PluginError` if it isn't there."""
    controller, network = settings.controller, settings.network
    return Plugins(
        controller=load(controller, "--controller") if is_plugin(controller) else None,
        network=load(network, "--network") if is_plugin(network) else None,
        torques={name: load(name, "--torque") for name in settings.torque},
        metrics={name: load(name, "--metric") for name in settings.metric},
    )


def _pilot(brief: Brief, plugins: Plugins, timing: Timing) -> Pilot:
    settings = brief.settings
    if plugins.controller is None:
        pilot = build_pilot(brief)
    else:
        pilot = own_pilot(plugins.controller, settings.controller, brief, brief.truth)
        if settings.reconfigure:
            raise SettingsError("--reconfigure needs nmpc or nmpc-learned: yours is one craft's")
    tick = timing.sample_s
    estimator = build_estimator(settings.estimator, settings.sensors, tick)
    pilot = pilot if estimator is None else replace(pilot, estimator=estimator)
    if settings.delay.foresight and settings.delay.samples(tick):
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
