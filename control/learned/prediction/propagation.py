"""Where a sequence of wheel torques leads: the end of the plan, and its slope by the torques.

The equations of an interval and of the end are those of `interval`; a plan chains any number of
intervals, each of its own length, and the chain rule their slopes, from the end backwards. In C
where there is a compiler (`propagate.c`), else in NumPy (`interpreted`), with the same result.
"""

from typing import Protocol

from ...ground.arrays import Array, Quaternion
from ...ground.spacecraft import Spacecraft
from ...model.appendage import AppendageNetwork
from ...model.momentum import MomentumModel
from .compiled import compile_propagator
from .interpreted import InterpretedPropagator
from .interval import interval_functions, numbers_of


class Propagator(Protocol):
    """Propagates the plans of one spacecraft, with the appendages of one network or none."""

    even: bool
    """Whether all intervals of a plan must be one control period, which a network stands for."""

    def end(
        self, model: MomentumModel, x0: Array, torque: Array, lengths: Array, goal: Quaternion
    ) -> Array:
        """End of a plan, as `interval` has it, from the state x0: torques (K, m), Nm, over
        intervals of so many seconds (K)."""

    def linearize(
        self, model: MomentumModel, x0: Array, torque: Array, lengths: Array, goal: Quaternion
    ) -> tuple[Array, Array, Array]:
        """End, its slope by the torques (conditions, K m), and the states (K + 1, states)."""


def build_propagator(
    spacecraft: Spacecraft, network: AppendageNetwork | None = None, backend: str = "auto"
) -> Propagator:
    """The spacecraft's propagator: compiled where that works, unless told "interpreted"."""
    size = None if network is None else network.size
    functions = interval_functions(spacecraft.wheels, spacecraft.actuation_rank, size)
    numbers = numbers_of(spacecraft, network)
    compiled = None if backend == "interpreted" else compile_propagator(functions, numbers)
    return compiled or InterpretedPropagator(functions, numbers)
