"""What a data sheet says of each instrument. All deviations are 1 sigma."""

from dataclasses import dataclass, field
from typing import Annotated

from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import Bounds, NotNegative, Positive, Settings, Share

Angle = Annotated[float, Bounds(0.0, 180.0)]
Axis = tuple[float, float, float]


@dataclass(frozen=True)
class StarTrackerSheet(Settings, group="tracker"):
    """A star tracker: attitudes with a time stamp, late, and none when it is dazzled or swept."""

    rate_hz: Positive
    """Attitudes a second, at most one a sample."""
    latency_s: NotNegative
    """From the exposure to the delivery, s, to the nearest sample."""
    across_arcsec: NotNegative
    """Noise about each axis across the boresight."""
    about_arcsec: NotNegative
    """Noise about the boresight, several times larger: stars lie close to it."""
    rate_limit_deg_s: Positive
    """Body rate above which stars smear and no attitude is found."""
    sun_exclusion_deg: Angle
    """Least angle between boresight and Sun, unless the Earth hides it."""
    earth_exclusion_deg: Angle
    """Least angle between boresight and the Earth's limb."""
    outlier_share: Share = 0.0
    """Share of the attitudes that are wrong by a turn of up to `outlier_deg`."""
    outlier_deg: Angle = 5.0
    boresight: Axis = (0.0, 0.0, 1.0)
    """Body axes, any length but zero."""

    def check(self) -> None:
        """There is a boresight."""
        _refuse_zero(self.boresight, "tracker")


@dataclass(frozen=True)
class GyroSheet(Settings, group="gyro"):
    """A three-axis gyro that is read at every sample."""

    angle_random_walk_deg_sqrt_h: NotNegative
    """White noise of the rate: the angle is off by this after an hour."""
    bias_instability_deg_h: NotNegative
    """Floor of the Allan deviation, by a Gauss-Markov process of `correlation_time_s`."""
    rate_random_walk_deg_h_sqrt_h: NotNegative
    """The bias is off by this after an hour, deg/h."""
    bias_deg_h: NotNegative
    """What calibration on the tracker has left of the turn-on bias when the flight begins."""
    scale_factor_ppm: NotNegative
    """Error of each axis's scale factor after calibration."""
    misalignment_mrad: NotNegative
    """Error of each axis's direction towards each other axis after calibration."""
    range_deg_s: Positive
    """Largest rate of an axis that can be told."""
    correlation_time_s: Positive = 500.0
    """Of the bias instability: the floor lies at 1.89 times this."""


@dataclass(frozen=True)
class TachometerSheet(Settings, group="tachometer"):
    """The tachometer of each wheel, read at every sample."""

    resolution_rpm: NotNegative
    """Step between the speeds it can tell; 0 tells all."""
    noise_rpm: NotNegative
    """Noise before the speed is rounded to a step."""


@dataclass(frozen=True)
class SunSensorSheet(Settings, group="sun"):
    """A Sun sensor: the direction of the Sun in body axes, none in the Earth's shadow."""

    rate_hz: Positive
    noise_deg: Positive
    """About each axis across the Sun's direction."""
    field_deg: Angle = 60.0
    """Largest angle between Sun and boresight; 180 stands for heads all around."""
    boresight: Axis = (1.0, 0.0, 0.0)
    """Body axes, any length but zero."""

    def check(self) -> None:
        """There is a boresight."""
        _refuse_zero(self.boresight, "sun")


@dataclass(frozen=True)
class DataSheet(Settings):
    """All instruments of a spacecraft."""

    tracker: StarTrackerSheet
    gyro: GyroSheet
    tachometer: TachometerSheet
    sun: SunSensorSheet | None = field(default=None)


def _refuse_zero(axis: Axis, whose: str) -> None:
    if not any(axis):
        raise SettingsError(f"--{whose}.boresight is 0 0 0: give an axis, any length but zero")
