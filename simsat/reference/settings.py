"""Which attitude is to be followed."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import Settings

Axis = tuple[float, float, float]
KNOWN = ("inertial", "nadir", "sun", "station")
PARALLEL = 1e-3  # rad: body axes closer than this decide no attitude


@dataclass(frozen=True)
class ReferenceSettings(Settings, group="reference"):
    """The attitude to follow over time."""

    to: Annotated[tuple[str, ...], tyro.conf.arg(name="", metavar="WHAT")] = ("inertial",)
    """inertial (the attitude --target), nadir, sun, station LAT LON (degrees), or a file: attitudes
    over time or targets with dwell times as CSV, or a CCSDS AEM."""
    boresight: Axis = (0.0, 0.0, 1.0)
    """Body axis that points to nadir, Sun or station."""
    second: Axis = (1.0, 0.0, 0.0)
    """Body axis that is turned as near as it can be to the velocity (nadir), the orbit's normal
    (station) or the Earth's north (sun)."""

    @property
    def file(self) -> Path | None:
        """The file that is followed, if it is one."""
        return None if self.to[0] in KNOWN else Path(self.to[0])

    @classmethod
    def flag(cls, name: str) -> str:
        """What is followed has the group's own name."""
        return "--reference" if name == "to" else super().flag(name)

    def check(self) -> None:
        """Something is followed, and two axes decide an attitude."""
        if not self.to:
            raise SettingsError("--reference: give inertial, nadir, sun, station LAT LON or a file")
        across = np.linalg.norm(np.cross(self.boresight, self.second))
        if not across > PARALLEL * np.linalg.norm(self.boresight) * np.linalg.norm(self.second):
            raise SettingsError(
                "--reference.boresight and --reference.second must be two different axes, not zero"
            )
