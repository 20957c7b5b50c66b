"""The settings of a flight: this dataclass is the command line and is saved with every run."""

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tyro

from simsat.control.correction.corrector import CorrectionSettings
from simsat.control.ground import attitude
from simsat.control.ground.arrays import Quaternion
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.own import Own
from simsat.control.ground.settings import Bounds, NotNegative, Positive, Settings
from simsat.control.learned.settings import LearnedSettings
from simsat.control.magnetic.settings import RodSettings
from simsat.control.nmpc.planner import NmpcSettings
from simsat.control.supervisor.faithful import FaithfulSettings
from simsat.control.supervisor.sound import SoundSettings
from simsat.control.supervisor.value import ValueSettings
from simsat.environment import EnvironmentSettings, OrbitSettings
from simsat.flight.delay import DelaySettings
from simsat.flight.onboard_field import OnboardSettings
from simsat.mjcf.shipped import MODELS
from simsat.reference.settings import ReferenceSettings
from simsat.sensors.settings import SensorSettings

RATE_MAX_DEG_S = 3600.0  # ten turns a second: beyond, a time step of 10 ms turns too far
SAMPLES_MAX = 10_000_000  # of a flight, which is kept in memory as a whole

Rate = Annotated[float, Bounds(-RATE_MAX_DEG_S, RATE_MAX_DEG_S)]
Names = tyro.conf.UseAppendAction[tuple[str, ...]]


@dataclass(frozen=True)
class NominalSettings(Settings, group="nominal"):
    """What the controller believes of the inertia: the file's diagonal times factors."""

    inertia_factors: tuple[Positive, Positive, Positive] | None = None
    """Belief of J's diagonal as a factor per axis, off-diagonals dropped. Default: the model
    file's nominal_inertia_factors, else 1 1 1."""
    mismatch: NotNegative = 1.0
    """Scale on the wrongness of that belief: 0 is the true inertia, 2 twice as wrong."""


@dataclass(frozen=True)
class StartSettings(Settings, group="start"):
    """State of motion at the start; at rest by default."""

    omega_deg_s: tuple[Rate, Rate, Rate] = (0.0, 0.0, 0.0)
    """Body rates at the start, deg/s, body axes."""
    wheel_speed_rpm: tuple[float, ...] = ()
    """Wheel speeds at the start, rpm, in the file's order of wheels; none given is all zero."""
    zero_momentum: bool = False
    """Choose the wheel speeds that cancel as much of the body's momentum as wheels can."""


@dataclass(frozen=True)
class CommonSettings(Settings):
    """What all flights of a campaign share."""

    model: Path = MODELS / "two_wheel" / "two_wheel.xml"
    """The spacecraft: an MJCF file, or the name of one in models/ (two_wheel, pyramid, ...)."""
    network: str = "pinn"
    """The network of controllers that have one: pinn or linear (beside the model), a file, a
    folder that training wrote, or an estimator of your own, package.module:name."""
    supervisor: Literal["faithful", "sound", "value"] = "faithful"
    """Rule by which nmpc-pinn-supervisor lets the network act: faithful is the paper's, sound never
    lets an accepted correction raise the energy V over a period, value asks that the planner's own
    cost falls."""
    estimator: Literal["auto", "mekf", "none"] = "auto"
    """What makes attitude and rates of the instruments' readings, for every controller: mekf is a
    multiplicative extended Kalman filter of attitude and gyro errors, none shows the controller the
    readings as they are, auto is mekf with a --sensors.preset and none without."""
    target: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Reference attitude, body -> inertial quaternion w x y z, for --reference inertial."""
    reference: ReferenceSettings = field(default_factory=ReferenceSettings)
    duration_s: Annotated[Positive | None, Own("time", 100.0)] = None
    """Length of the flight, s: a whole number of control periods where their length is given too,
    else up to one longer; some 100 of the craft's own
    seconds (18.5 natural times, sqrt(J / u)) unless given."""
    sample_s: Annotated[Positive | None, Own("time", 0.05)] = None
    """Interval between samples and environment updates, s: divides the control period; some 0.05
    of the craft's own seconds unless given."""
    keep_s: Positive | None = None
    """Interval of the samples that log, tables and recording keep, s: a whole number of samples;
    default all. 1 on flights of hours, 10 on flights of days."""
    torque: Names = ()
    """External torque of your own, package.module:name, a function (t, q) -> Nm in body axes;
    repeat the flag for several."""
    metric: Names = ()
    """Metric of your own, package.module:name, a function of the flight; repeat the flag for
    several."""
    fault: Names = ()
    """What breaks in flight, PART:KIND[=VALUE]@START[-END] in s: wheel_z:seize@4,
    wheel_z:dead@6-20, wheel_z:weak=0.3@4, wheel_z:friction=0.002@4 (Nm), wheel_z:tachometer@4,
    tracker:out@10-40, gyro_x:stuck@5, gyro_y:bias=0.1@5 (deg/s), body:inertia=1.3@8; repeat the
    flag for several."""
    reconfigure: bool = False
    """Notice wheels that fail and go on with those that are left (nmpc, nmpc-learned)."""
    nominal: NominalSettings = field(default_factory=NominalSettings)
    nmpc: NmpcSettings = field(default_factory=NmpcSettings)
    learned: LearnedSettings = field(default_factory=LearnedSettings)
    correction: CorrectionSettings = field(default_factory=CorrectionSettings)
    faithful: FaithfulSettings = field(default_factory=FaithfulSettings)
    sound: SoundSettings = field(default_factory=SoundSettings)
    value: ValueSettings = field(default_factory=ValueSettings)
    rods: RodSettings = field(default_factory=RodSettings)
    start: StartSettings = field(default_factory=StartSettings)
    orbit: OrbitSettings = field(default_factory=OrbitSettings)
    environment: EnvironmentSettings = field(default_factory=EnvironmentSettings)
    sensors: SensorSettings = field(default_factory=SensorSettings)
    delay: DelaySettings = field(default_factory=DelaySettings)
    onboard: OnboardSettings = field(default_factory=OnboardSettings)

    def check(self) -> None:
        """The target is an attitude."""
        if not has_direction(self.target):
            row = _row(self.target)
            raise SettingsError(f"--target must be a quaternion w x y z, not all zero, got {row}")

    @property
    def files(self) -> dict[str, Path]:
        """Files that decide a flight beside model and networks, by the name of their setting."""
        named = {"orbit.tle": self.orbit.tle, "reference.to": self.reference.file}
        return {name: path for name, path in named.items() if path is not None}

    @property
    def q_target(self) -> Quaternion:
        """The target attitude as a unit quaternion."""
        return attitude.normalized(np.array(self.target))


@dataclass(frozen=True)
class FlightSettings(CommonSettings):
    """Everything that decides a flight's numbers."""

    controller: str = "nmpc"
    """The controller's name, or one of your own, package.module:name; an unknown name lists those
    that exist."""
    axis: tuple[float, float, float] = (0.48, -0.64, 0.60)  # off every principal axis
    """Axis of the initial rotation away from the target, any length but zero."""
    angle_deg: float = 125.0
    """Angle of the initial rotation away from the target, degrees."""

    def check(self) -> None:
        """There is a rotation to undo."""
        super().check()
        if not has_direction(self.axis):
            row = _row(self.axis)
            raise SettingsError(f"--axis must be three finite numbers, not all zero, got {row}")
        if self.angle_deg == 0.0:
            raise SettingsError("--angle-deg is 0: give a finite number other than zero")

    @property
    def q_start(self) -> Quaternion:
        """The attitude at the start: the target turned by the initial rotation."""
        return attitude.multiply(self.q_target, self.turn)

    @property
    def turn(self) -> Quaternion:
        """The initial rotation."""
        return attitude.from_axis_angle(np.array(self.axis), math.radians(self.angle_deg))


def flight_of(
    common: CommonSettings, controller: str, axis: tuple[float, float, float], angle_deg: float
) -> FlightSettings:
    """One flight of those that share some settings."""
    shared = {f.name: getattr(common, f.name) for f in fields(CommonSettings)}
    return FlightSettings(**shared, controller=controller, axis=axis, angle_deg=angle_deg)


def as_json(settings: Any) -> Any:
    """Settings as plain JSON values."""
    if dataclasses.is_dataclass(settings):
        return {f.name: as_json(getattr(settings, f.name)) for f in dataclasses.fields(settings)}
    if isinstance(settings, dict):
        return {key: as_json(value) for key, value in settings.items()}
    if isinstance(settings, (list, tuple)):
        return [as_json(value) for value in settings]
    if isinstance(settings, Enum):
        return settings.value
    if isinstance(settings, Path):
        return str(settings)
    return settings


def has_direction(values: Iterable[float]) -> bool:
    """Whether the vector can be normalized: a length that neither vanishes nor overflows."""
    numbers = [float(value) for value in values]  # overflow silently, as NumPy's do not
    return 0.0 < math.sqrt(sum(number * number for number in numbers)) < math.inf


def _row(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)
