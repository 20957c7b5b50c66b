"""The planned trajectory: torques for every period from here to rest, and how far it has come.

* SLEW: K periods to rest in the arrival attitude.
* ARRIVAL: the last of them. phi_n is past help, the rest still arrives exactly.
* HOLD: at the target, arrival a few periods from now, every period anew.
"""

from dataclasses import dataclass, replace
from enum import Enum, StrEnum

import numpy as np

from ...ground.arrays import Array
from ...ground.units import Units
from .terminal import TerminalSolution


class TrajectoryStatus(StrEnum):
    """What a command belongs to, as a sentence."""

    SLEW = "The shortest slew left is flown."
    STRETCHED = "The slew takes longer than planned."
    OPEN_ENDED = "A slew too long, or too close to a speed limit, to be ended exactly yet."
    ARRIVAL = "The last periods arrive exactly."
    REPEATED = "The arrival missed and is flown again."
    HOLD = "The target is held."


class Phase(Enum):
    """Part of the trajectory."""

    SLEW = "on the way"
    ARRIVAL = "about to arrive"
    HOLD = "arrived"


@dataclass(frozen=True)
class Trajectory:
    """What is planned from a control instant on."""

    phase: Phase
    torque: Array
    """Torque the rotors are to keep in each period, Nm, shape (K, m); none before a search."""
    searches_left: int
    """How often the slew's shape will still be sought."""
    searches: int = 0
    """Searches made since the flight began: numbers the random guesses."""
    search_in: int = 0
    """Periods until the next one."""
    status: TrajectoryStatus = TrajectoryStatus.SLEW
    solution: TerminalSolution | None = None
    """The exact arrival, where there is one."""
    overruns: int = 0
    """Periods by which the arrival has been put off."""
    bias: float = 0.0
    """phi_n aimed at, rad (see `drift`)."""
    repeated: bool = False
    """Whether this is the second try at an arrival that missed."""

    @property
    def terminal_error(self) -> float:
        """Largest terminal condition left over, rad or rad/s; NaN without an exact arrival."""
        return np.nan if self.solution is None else self.solution.terminal_error

    def in_units(self, units: Units) -> "Trajectory":
        """Torques in other units; the solution stays in the planner's."""
        return replace(self, torque=self.torque / units.torque)
