"""The three layers of the controller, as the loop sees them.

At every control instant: a planner proposes wheel torques, a corrector adds a learned share, a
supervisor says how much of that share may act. Each takes its own memory and returns the next one;
None is the memory of a layer that has just been switched on.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from ..ground.arrays import WheelVector
from .belief import Belief
from .measurement import Measurement
from .plan import Plan
from .verdict import Verdict

Memory = Any


@dataclass(frozen=True)
class Correction:
    """A torque to add on the wheels."""

    torque: WheelVector
    """What is asked for, Nm, inside the correction's own limit; zero while switched off."""
    estimate: WheelVector
    """Estimated residual torque on the wheel axes before any limit, Nm."""
    active: bool
    """False while the attitude error is too small for the correction (see `switch`)."""
    signals: Mapping[str, float] = field(default_factory=dict)
    """Anything else worth a curve in the recording, by name with its unit."""


@runtime_checkable
class Estimator(Protocol):
    """Before layer one: makes of what instruments say what the layers are told."""

    def estimate(self, measurement: Measurement, memory: Memory) -> tuple[Measurement, Memory]:
        """The measurement that planner, corrector and supervisor see."""
        ...

    def signals(self, memory: Memory) -> Mapping[str, float]:
        """Anything worth a curve in the recording, by name with its unit."""
        ...


@runtime_checkable
class Planner(Protocol):
    """Layer one: plans the manoeuvre on a nominal model."""

    def plan(self, measurement: Measurement, memory: Memory) -> tuple[Plan, Memory]:
        """The torque for the coming period, with the plan it comes from."""
        ...


@runtime_checkable
class Corrector(Protocol):
    """Layer two: estimates what the nominal model misses."""

    def correct(
        self, measurement: Measurement, plan: Plan, memory: Memory
    ) -> tuple[Correction, Memory]:
        """The torque to add to the plan's."""
        ...


@runtime_checkable
class Supervisor(Protocol):
    """Layer three: bounds or rejects the correction."""

    def supervise(
        self, measurement: Measurement, plan: Plan, correction: Correction, memory: Memory
    ) -> tuple[Verdict, Memory]:
        """The share of the correction that may act."""
        ...


@dataclass(frozen=True)
class InTransit:
    """Commands between controller and motors."""

    pending: tuple[tuple[float, WheelVector], ...]
    """(seconds, Nm) in the order in which they will act."""
    acting: WheelVector
    """The command in force just now, Nm."""
    acted: WheelVector
    """Mean command over the period that ends now, Nm."""


class Foresees(Protocol):
    """Beside the estimator: knows where the craft will be when a command acts."""

    def foreseen(
        self, measurement: Measurement, transit: InTransit, belief: Belief | None
    ) -> Measurement:
        """The measurement as it will be then; `belief` is what the planner has learned."""
        ...


@dataclass(frozen=True)
class Pilot:
    """A complete controller: a planner, and the layers above it that are switched on."""

    planner: Planner
    corrector: Corrector | None = None
    supervisor: Supervisor | None = None
    estimator: Estimator | None = None
    foresight: Foresees | None = None
