"""A controller of the user's own, made into a pilot.

It is a function or class called with the `Brief`. What it returns may be a control law, called with
every measurement; a planner, with `plan`; or a whole `Pilot`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simsat.control.ground.arrays import Array, WheelVector
from simsat.control.ground.errors import PluginError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.interface.blind import plan_blind
from simsat.control.interface.layers import (
    Correction,
    Corrector,
    Memory,
    Pilot,
    Planner,
    Supervisor,
)
from simsat.control.interface.measurement import Measurement
from simsat.control.interface.plan import Plan
from simsat.control.interface.verdict import Verdict
from simsat.flight.plugins import named, shown


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
    rods: int

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
            dipole = None if plan.dipole is None else np.asarray(plan.dipole, float)
            signals = {str(key): float(value) for key, value in plan.signals.items()}
            status = plan.status if isinstance(plan.status, str) else str(plan.status)
            plan = replace(
                plan, torque=torque, dipole=dipole, signals=signals, status=status,
                failed=bool(plan.failed),
            )  # fmt: skip
        _refuse_misfit(torque, self.wheels, f"controller '{self.name}' answered")
        if dipole is not None:
            self._refuse_misfit_dipole(dipole)
        return plan

    def _refuse_misfit_dipole(self, dipole: Array) -> None:
        if dipole.shape != (self.rods,):
            raise PluginError(
                f"controller '{self.name}' answered dipoles of shape {dipole.shape}: the "
                f"spacecraft has {self.rods} magnetic rods"
            )
        if not np.isfinite(dipole).all():
            raise PluginError(
                f"controller '{self.name}' answered the dipole {np.array2string(dipole)} A m^2: "
                "it must be finite"
            )


@dataclass(frozen=True)
class CheckedCorrector:
    """A corrector whose errors and answers are named for what they are."""

    inner: Corrector
    name: str
    wheels: int

    def correct(
        self, measurement: Measurement, plan: Plan, memory: Memory
    ) -> tuple[Correction, Memory]:
        """The inner correction. Raises `PluginError` if it fails or doesn't fit the wheels."""
        with named(f"corrector of '{self.name}'"):
            asked, memory = self.inner.correct(measurement, plan, memory)
            torque = np.asarray(asked.torque, float)
            estimate = np.asarray(asked.estimate, float)
            signals = {str(key): float(value) for key, value in asked.signals.items()}
        for part in (torque, estimate):
            _refuse_misfit(part, self.wheels, f"corrector of '{self.name}' answered")
        return Correction(torque, estimate, bool(asked.active), signals), memory


@dataclass(frozen=True)
class CheckedSupervisor:
    """A supervisor whose errors and answers are named for what they are."""

    inner: Supervisor
    name: str

    def supervise(
        self, measurement: Measurement, plan: Plan, correction: Correction, memory: Memory
    ) -> tuple[Verdict, Memory]:
        """The inner verdict. Raises `PluginError` if it fails or is none."""
        with named(f"supervisor of '{self.name}'"):
            verdict, memory = self.inner.supervise(measurement, plan, correction, memory)
        if not isinstance(verdict, Verdict) or not 0.0 <= verdict.alpha <= 1.0:
            raise PluginError(
                f"supervisor of '{self.name}' answered {shown(verdict)}: a Verdict with an alpha "
                "from 0 to 1 is wanted"
            )
        return verdict, memory


def _refuse_misfit(torque: Array, wheels: int, who: str) -> None:
    if torque.shape != (wheels,):
        raise PluginError(
            f"{who} torques of shape {torque.shape}: the spacecraft has {wheels} wheels"
        )


def own_pilot(make: Callable[..., Any], name: str, brief: Any, craft: Spacecraft) -> Pilot:
    """The pilot that the user's function or class makes of the brief.

    Raises `PluginError` if it fails or returns nothing that can fly.
    """
    if not callable(make):
        raise PluginError(f"controller '{name}' is no function or class to call with the brief")
    with named(f"controller '{name}'"):
        made = make(brief)
    if isinstance(made, Pilot):
        return _checked_pilot(made, name, craft)
    if hasattr(made, "plan"):
        return Pilot(_checked(made, name, craft))
    if callable(made):
        return Pilot(_checked(Law(made), name, craft))
    raise PluginError(
        f"controller '{name}' made a {type(made).__name__}: it must be called with a measurement, "
        "have a method 'plan', or be a Pilot"
    )


def _checked(planner: Planner, name: str, craft: Spacecraft) -> Checked:
    return Checked(planner, name, craft.wheels, craft.rods.count)


def _checked_pilot(pilot: Pilot, name: str, craft: Spacecraft) -> Pilot:
    corrector, supervisor = pilot.corrector, pilot.supervisor
    return Pilot(
        _checked(pilot.planner, name, craft),
        None if corrector is None else CheckedCorrector(corrector, name, craft.wheels),
        None if supervisor is None else CheckedSupervisor(supervisor, name),
        pilot.estimator,
    )
