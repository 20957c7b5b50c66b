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
from ..ground.settings import NotNegative, Settings


@dataclass(frozen=True)
class SwitchSettings(Settings, group="correction.switch"):
    """When the learned correction acts."""

    off_below_deg: NotNegative = 1.0
    """Attitude error below which the correction goes off, degrees."""
    on_above_deg: NotNegative = 1.3
    """Attitude error above which it comes back, degrees; not below off_below_deg."""

    def check(self) -> None:
        """The band between the two has a width."""
        if self.off_below_deg > self.on_above_deg:
            raise SettingsError(
                f"{self.flag('on_above_deg')} must not be below {self.flag('off_below_deg')}; got "
                f"{self.on_above_deg:g} and {self.off_below_deg:g}"
            )


def switched(on: bool, error_angle: float, settings: SwitchSettings) -> bool:
    """Whether the correction acts now, given whether it did and the attitude error (rad)."""
    threshold = settings.off_below_deg if on else settings.on_above_deg
    return error_angle >= math.radians(threshold)
