"""The correction's switch: off near the target, with hysteresis.

The paper switches its correction off below 1 degree. A single threshold chatters: the correction
moves the error across it, is switched off, drifts back. So it goes off below one angle and comes
back above a larger one. The switch belongs to the correction, supervised or not. With it the
correction cannot act where both of the paper's metrics live, below 0.5 degrees: it changes only
how the planner arrives there.
"""

import math
from dataclasses import dataclass

from ..ground.errors import SettingsError


@dataclass(frozen=True)
class SwitchSettings:
    """When the learned correction acts."""

    off_below_deg: float = 1.0
    """Attitude error below which the correction goes off, degrees."""
    on_above_deg: float = 1.3
    """Attitude error above which it comes back, degrees; not below off_below_deg."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.off_below_deg <= self.on_above_deg:
            raise SettingsError(
                f"--correction.switch.on-above-deg must not be below --correction.switch."
                f"off-below-deg, nor that below 0; got {self.on_above_deg:g} and "
                f"{self.off_below_deg:g}"
            )


def switched(on: bool, error_angle: float, settings: SwitchSettings) -> bool:
    """Whether the correction acts now, given whether it did and the attitude error (rad)."""
    threshold = settings.off_below_deg if on else settings.on_above_deg
    return error_angle >= math.radians(threshold)
