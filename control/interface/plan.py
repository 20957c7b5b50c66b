"""What a planner answers: the torque for the coming period, and what it has to say about it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Protocol, Self, runtime_checkable

from ..ground.arrays import RodVector, WheelVector
from ..ground.units import Units
from .belief import Belief


@runtime_checkable
class Convertible(Protocol):
    """Evidence that holds numbers with units."""

    def in_units(self, units: Units) -> Self:
        """The same in other units."""
        ...


@dataclass(frozen=True)
class Plan:
    """The command for the coming period.

    A control law needs no more than the torque: `Plan(torque)`.
    """

    torque: WheelVector
    """Motor torque on each rotor, Nm; the loop cuts it to the wheels' limits."""
    status: str = "A control law was followed."
    """Where the torque comes from, as a sentence. A member of a string enumeration goes by its name
    in tables."""
    failed: bool = False
    """Whether the planner could not do its work and this is a stand-in. A flight in which it fails
    for long ends."""
    evidence: Any = None
    """What the torque was taken from (a solution, a trajectory), for supervisors and tests."""
    signals: Mapping[str, float] = field(default_factory=dict)
    """Anything worth a curve in the recording, by name with its unit (time_to_go_s)."""
    dipole: RodVector | None = None
    """Dipole of each magnetic rod over the coming period, A m^2, in the mean; the loop cuts it to
    the rods' limits. None leaves the rods off."""
    belief: Belief | None = None
    """What the planner has learned of the spacecraft, if it learns; the rods' planner uses it."""

    @property
    def label(self) -> str:
        """The status in a word or two, for tables and the recording."""
        return self.status.name.lower() if isinstance(self.status, Enum) else self.status

    def in_units(self, units: Units) -> "Plan":
        """The same in other units; a signal's is what its name ends in."""
        evidence = self.evidence
        return replace(
            self,
            torque=self.torque / units.torque,
            evidence=evidence.in_units(units) if isinstance(evidence, Convertible) else evidence,
            belief=None if self.belief is None else self.belief.in_units(units),
            signals={name: value / units.of(name) for name, value in self.signals.items()},
        )
