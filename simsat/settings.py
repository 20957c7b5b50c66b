"""The settings of a flight: this dataclass is the command line and is saved with every run."""

import dataclasses
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Literal

import numpy as np

from simsat.control.correction.corrector import CorrectionSettings
from simsat.control.ground import attitude
from simsat.control.ground.arrays import Quaternion
from simsat.control.ground.errors import ModelError, SettingsError, require
from simsat.control.learned.settings import LearnedSettings
from simsat.control.nmpc.planner import NmpcSettings
from simsat.control.supervisor.faithful import FaithfulSettings
from simsat.control.supervisor.sound import SoundSettings
from simsat.control.supervisor.value import ValueSettings
from simsat.environment import EnvironmentSettings, OrbitSettings
from simsat.flight.sensors import SensorSettings

MODELS = (Path(__file__).parent / "models").resolve()
"""The spacecraft that come with the project, one folder each."""

RATE_MAX_DEG_S = 3600.0  # ten turns a second: beyond, a time step of 10 ms turns too far
SAMPLES_MAX = 10_000_000  # of a flight, which is kept in memory as a whole
DEFAULT_AXIS = (0.48, -0.64, 0.60)  # off every principal axis


@dataclass(frozen=True)
class NominalSettings:
    """What the controller believes of the inertia: the file's diagonal times factors."""

    inertia_factors: tuple[float, float, float] | None = None
    """Belief of J's diagonal as a factor per axis, off-diagonals dropped. Default: the model
    file's nominal_inertia_factors, else 1 1 1."""
    mismatch: float = 1.0
    """Scale on the wrongness of that belief: 0 is the true inertia, 2 twice as wrong."""

    def __post_init__(self) -> None:
        require(self, "nominal", "mismatch", 0.0)
        factors = self.inertia_factors
        _refuse(
            factors is not None and not all(0.0 < factor < math.inf for factor in factors),
            f"--nominal.inertia-factors must be above zero and finite, got {_row(factors or ())}",
        )


@dataclass(frozen=True)
class StartSettings:
    """State of motion at the start; at rest by default."""

    omega_deg_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Body rates at the start, deg/s, body axes."""
    wheel_speed_rpm: tuple[float, ...] = ()
    """Wheel speeds at the start, rpm, in the file's order of wheels; none given is all zero."""
    zero_momentum: bool = False
    """Choose the wheel speeds that cancel as much of the body's momentum as wheels can."""

    def __post_init__(self) -> None:
        _refuse(
            not all(abs(rate) <= RATE_MAX_DEG_S for rate in self.omega_deg_s),
            f"--start.omega-deg-s must be three rates within {RATE_MAX_DEG_S:g} deg/s, "
            f"got {_row(self.omega_deg_s)}",
        )


@dataclass(frozen=True)
class FlightSettings:
    """Everything that decides a flight's numbers."""

    model: Path = MODELS / "two_wheel" / "two_wheel.xml"
    """The spacecraft: an MJCF file, or the name of one in models/ (two_wheel, pyramid, ...)."""
    controller: str = "nmpc"
    """The controller's name; an unknown name lists those that exist."""
    network: str = "pinn"
    """The network of controllers that have one: pinn or linear (beside the model), a file, or a
    folder that training wrote."""
    supervisor: Literal["faithful", "sound", "value"] = "faithful"
    """Rule by which nmpc-pinn-supervisor lets the network act: faithful is the paper's, sound never
    lets an accepted correction raise the energy V over a period, value asks that the planner's own
    cost falls."""
    axis: tuple[float, float, float] = DEFAULT_AXIS
    """Axis of the initial rotation away from the target, any length but zero."""
    angle_deg: float = 125.0
    """Angle of the initial rotation away from the target, degrees."""
    target: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Reference attitude, body -> inertial quaternion w x y z."""
    duration_s: float = 100.0
    """Length of the flight, s: a whole number of control periods."""
    sample_s: float = 0.05
    """Interval between samples and environment updates, s: divides the control period."""
    nominal: NominalSettings = field(default_factory=NominalSettings)
    nmpc: NmpcSettings = field(default_factory=NmpcSettings)
    learned: LearnedSettings = field(default_factory=LearnedSettings)
    correction: CorrectionSettings = field(default_factory=CorrectionSettings)
    faithful: FaithfulSettings = field(default_factory=FaithfulSettings)
    sound: SoundSettings = field(default_factory=SoundSettings)
    value: ValueSettings = field(default_factory=ValueSettings)
    start: StartSettings = field(default_factory=StartSettings)
    orbit: OrbitSettings = field(default_factory=OrbitSettings)
    environment: EnvironmentSettings = field(default_factory=EnvironmentSettings)
    sensors: SensorSettings = field(default_factory=SensorSettings)

    def __post_init__(self) -> None:
        _refuse(
            not has_direction(self.axis),
            f"--axis must be three finite numbers, not all zero, got {_row(self.axis)}",
        )
        _refuse(
            not math.isfinite(self.angle_deg) or self.angle_deg == 0.0,
            f"--angle-deg must be finite and not zero, got {self.angle_deg:g}",
        )
        _refuse(
            not has_direction(self.target),
            f"--target must be a quaternion w x y z, not all zero, got {_row(self.target)}",
        )
        for name in ("duration_s", "sample_s"):
            value = getattr(self, name)
            flag = name.replace("_", "-")
            _refuse(
                not (math.isfinite(value) and value > 0.0),
                f"--{flag} must be a finite number above zero, got {value:g}",
            )
        samples = self.duration_s / self.sample_s
        _refuse(
            samples > SAMPLES_MAX,
            f"--duration-s {self.duration_s:g} in samples of --sample-s {self.sample_s:g} s makes "
            f"{samples:.3g} samples, more than {SAMPLES_MAX:g}",
        )
        for name, value in _floats(self):
            flag = name.replace("_", "-")
            _refuse(not math.isfinite(value), f"--{flag} must be finite, got {value:g}")

    @property
    def q_target(self) -> Quaternion:
        """The target attitude as a unit quaternion."""
        return attitude.normalized(np.array(self.target))

    @property
    def q_start(self) -> Quaternion:
        """The attitude at the start: the target turned by the initial rotation."""
        turn = attitude.from_axis_angle(np.array(self.axis), math.radians(self.angle_deg))
        return attitude.multiply(self.q_target, turn)


@dataclass(frozen=True)
class RunSettings(FlightSettings):
    """Fly one spacecraft once and keep a recording, a picture, metrics and time series."""

    out: Path | None = None
    """Folder to write, which must not exist yet; default a new one under runs/."""
    recording: bool = True
    """Write recording.rrd."""


def find_model(model: Path) -> Path:
    """The file that `--model` names: a path, or a folder's name in models/.

    Raises `ModelError` on a name that none of them has.
    """
    if model.is_file() or len(model.parts) != 1 or model.suffix:
        return model
    named = MODELS / model / f"{model.name}.xml"
    if not named.exists():
        names = sorted(
            path.stem for path in MODELS.glob("*/*.xml") if path.stem == path.parent.name
        )
        raise ModelError(f"no model '{model}'; there are: {', '.join(names)}, or name an MJCF file")
    return named


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


def _refuse(bad: bool, sentence: str) -> None:
    if bad:
        raise SettingsError(sentence)


def has_direction(values: Iterable[float]) -> bool:
    """Whether the vector can be normalized: a length that neither vanishes nor overflows."""
    numbers = [float(value) for value in values]  # overflow silently, as NumPy's do not
    return 0.0 < math.sqrt(sum(number * number for number in numbers)) < math.inf


def _floats(settings: Any, prefix: str = "") -> Iterator[tuple[str, float]]:
    """Every number with a fraction in the settings, by its dotted name."""
    for field_ in dataclasses.fields(settings):
        name, value = prefix + field_.name, getattr(settings, field_.name)
        if dataclasses.is_dataclass(value):
            yield from _floats(value, f"{name}.")
        else:
            listed = value if isinstance(value, tuple) else (value,)
            yield from ((name, part) for part in listed if isinstance(part, float))


def _row(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)
