"""What the controller sees: the truth, white noise on it, or instruments of a data sheet.

The default figures of the white noise are a small satellite's class of instruments: a star tracker
of 10 arcseconds (Blue Canyon NST: 6 across the boresight, 40 about it), a tactical MEMS gyro
(Sensonor STIM210: angle random walk 0.15 deg/sqrt(h), bias 0.3 deg/h), wheel tachometers of 1 rpm
(assumed), a magnetometer of 20 nT (NewSpace Systems NMRM: 16) with 100 nT left after calibration
(assumed), and one sample of delay for reading them all (assumed).
"""

from dataclasses import dataclass
from typing import Literal

import tyro

from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import CountOrNone, NotNegative, Settings, changed, setting
from simsat.sensors.presets import PRESETS
from simsat.sensors.sheets import DataSheet

Names = tyro.conf.UseAppendAction[tuple[str, ...]]


@dataclass(frozen=True)
class SensorSettings(Settings, group="sensors"):
    """What the controller sees: the truth, white noise on it, or instruments of a data sheet."""

    enabled: bool = False
    """White noise, bias and delay on the truth, as the settings below say."""
    preset: Literal["cubesat", "smallsat", "highend"] | None = None
    """Instruments as in a data sheet, each with its own rate, latency and blind spots; the settings
    of the white noise below then count for nothing."""
    figure: Names = ()
    """A figure of the preset's data sheet replaced, tracker.rate-limit-deg-s=2; repeat the flag for
    several."""
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
    magnetometer; with a preset too."""
    magnetometer_bias_nT: NotNegative = 100.0
    """Standard deviation of the magnetometer's bias, nT: drawn once per flight and axis; with a
    preset too."""
    relative_noise_percent: NotNegative = 0.0
    """Further noise on every quantity, percent of its own size: attitude (its rotation from the
    inertial axes), rates, wheel speeds."""
    delay_samples: CountOrNone = 1
    """Age of what the controller sees, in samples; it isn't told."""
    seed: CountOrNone = 0
    """Seed of all noise: the same seed gives the same flight."""

    def check(self) -> None:
        """One kind of sensors at most, and figures that the data sheet has."""
        if self.preset is not None and self.enabled:
            raise SettingsError(
                f"--sensors.preset {self.preset} has its own noise: leave out --sensors.enabled"
            )
        if self.preset is None and self.figure:
            raise SettingsError("--sensors.figure changes a preset: give --sensors.preset too")
        if self.figure:
            assert self.sheet is not None

    @property
    def sheet(self) -> DataSheet | None:
        """The preset's data sheet with the figures replaced."""
        if self.preset is None:
            return None
        sheet = PRESETS[self.preset]
        for text in self.figure:
            sheet = _with_figure(sheet, text)
        return sheet

    @property
    def noisy(self) -> bool:
        """Whether anything is drawn from the seed."""
        return self.enabled or self.preset is not None


def _with_figure(sheet: DataSheet, text: str) -> DataSheet:
    """The sheet with one figure replaced. Raises `SettingsError` unless text is NAME=VALUE."""
    name, equals, value = text.partition("=")
    name = name.strip().replace("-", "_")
    try:
        numbers = [float(part) for part in value.split()]
    except ValueError:
        numbers = []
    if not equals or not numbers:
        raise SettingsError(
            f"--sensors.figure is '{text}': give NAME=NUMBER (three for an axis), for example "
            "tracker.rate-limit-deg-s=2"
        )
    _, now = setting(sheet, name)
    return changed(sheet, {name: tuple(numbers) if isinstance(now, tuple) else numbers[0]})
