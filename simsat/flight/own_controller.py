"""A controller of the user's own, made into a pilot.

It is a function or class called with the `Brief`. What it returns may be a control law, called with
every measurement; a planner, with `plan`; or a whole `Pilot`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simsat.control.ground.arrays import WheelVector
from simsat.control.ground.errors import PluginError
from simsat.control.interface.blind import plan_blind
from simsat.control.interface.layers import Memory, Pilot, Planner
from simsat.control.interface.measurement import Measurement
from simsat.control.interface.plan import Plan
from simsat.flight.plugins import named


@dataclass(frozen=True)
class Law:
    """A planner that asks a function of the measurement alone."""

    law: Callable[[Measurement], Any]

    def plan(self, measurement: Measurement, memory: Memory) -> tuple[Plan, Memory]:
        """The law's torque (Nm, shape (m,)), or the `Plan` it answers."""
        answer = self.law(measurement)
        if not isinstance(answer, Plan):
            answer = Plan(np.asarray(answer, float))
        return answer, memory


@dataclass(frozen=True)
class Checked:
    """A planner whose errors and answers are named for what they are."""

    inner: Planner
    name: str
    wheels: int

    def plan(self, measurement: Measurement, memory: Memory) -> tuple[Plan, Memory]:
        """The inner plan. Raises `PluginError` if it fails or doesn't fit the wheels."""
        with named(f"controller '{self.name}'"):
            plan, memory = self.inner.plan(measurement, memory)
        return self._checked(plan), memory

    def fly_on(self, torque: WheelVector, memory: Memory) -> tuple[Plan, Memory]:
        """The inner planner's answer to a period without a measurement; no torque unless it has a
        method `fly_on`. Raises `PluginError` likewise."""
        with named(f"controller '{self.name}'"):
            plan, memory = plan_blind(self.inner, torque, memory)
        return self._checked(plan), memory

    def _checked(self, plan: Plan) -> Plan:
        with named(f"controller '{self.name}'"):
            torque = np.asarray(plan.torque, float)
        if torque.shape != (self.wheels,):
            raise PluginError(
                f"controller '{self.name}' answered torques of shape {torque.shape}: the "
                f"spacecraft has {self.wheels} wheels"
            )
        return replace(plan, torque=torque)


def own_pilot(make: Callable[..., Any], name: str, brief: Any, wheels: int) -> Pilot:
    """The pilot that the user's function or class makes of the brief.

    Raises `PluginError` if it fails or returns nothing that can fly.
    """
    if not callable(make):
        raise PluginError(f"controller '{name}' is no function or class to call with the brief")
    with named(f"controller '{name}'"):
        made = make(brief)
    if isinstance(made, Pilot):
        return replace(made, planner=Checked(made.planner, name, wheels))
    if hasattr(made, "plan"):
        return Pilot(Checked(made, name, wheels))
    if callable(made):
        return Pilot(Checked(Law(made), name, wheels))
    raise PluginError(
        f"controller '{name}' made a {type(made).__name__}: it must be called with a measurement, "
        "have a method 'plan', or be a Pilot"
    )
