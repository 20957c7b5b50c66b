"""A planner that notices failed wheels and goes on with those that are left.

The planners for every single failure are there before the flight; the one for a second failure is
made when the first has happened.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ..ground.arrays import WheelVector
from ..ground.spacecraft import Spacecraft
from ..interface.belief import Belief
from ..interface.blind import no_torque, plan_blind
from ..interface.layers import Memory, Planner
from ..interface.measurement import Measurement
from ..interface.plan import Plan
from .reduced import narrowed, reduced, widened
from .wheels import Fate, WheelMonitor, all_sound, watched

Fates = tuple[Fate | None, ...]


@dataclass(frozen=True)
class MonitoredMemory:
    """What one plan hands to the next."""

    monitor: WheelMonitor
    planner: Planner
    inner: Memory = None
    """The memory of the planner that flies now."""


@dataclass(frozen=True)
class MonitoredPlanner:
    """The planner of all wheels until one fails, then that of the others."""

    craft: Spacecraft
    """As it is believed to be."""
    period: float
    """Control period, s."""
    whole: Planner
    make: Callable[[Spacecraft], Planner]
    """Makes the planner of a craft with fewer wheels."""
    prepared: Mapping[Fates, Planner]
    """Those that are there already."""

    def plan(
        self, measurement: Measurement, memory: MonitoredMemory | None
    ) -> tuple[Plan, MonitoredMemory]:
        """The torque for the coming period, by the wheels that are left."""
        memory = memory or MonitoredMemory(all_sound(self.craft.wheels), self.whole)
        monitor = watched(memory.monitor, measurement.sensed, self.craft, self.period)
        if monitor.fates != memory.monitor.fates:
            memory = MonitoredMemory(monitor, self._planner(monitor.fates))
        if not monitor.sound:
            plan = no_torque(self.craft.wheels)
            return self._signed(plan, monitor), replace(memory, monitor=monitor)
        told = measurement
        if len(monitor.sound) < self.craft.wheels:
            told = narrowed(measurement, self.craft, monitor.fates)
        plan, inner = memory.planner.plan(told, memory.inner)
        torque = widened(plan.torque, monitor.fates)
        plan = replace(plan, torque=torque, belief=_for_all(plan.belief, monitor.fates))
        return self._signed(plan, monitor), MonitoredMemory(monitor, memory.planner, inner)

    def fly_on(
        self, torque: WheelVector, memory: MonitoredMemory | None
    ) -> tuple[Plan, MonitoredMemory | None]:
        """The rest of the plan without a measurement; nothing is noticed."""
        if memory is None or not memory.monitor.sound:
            return no_torque(self.craft.wheels), memory
        left = torque[list(memory.monitor.sound)]
        plan, inner = plan_blind(memory.planner, left, memory.inner)
        plan = replace(plan, torque=widened(plan.torque, memory.monitor.fates))
        monitor = replace(memory.monitor, torque_before=torque)
        return plan, replace(memory, monitor=monitor, inner=inner)

    def _planner(self, fates: Fates) -> Planner:
        if fates in self.prepared:
            return self.prepared[fates]
        craft = reduced(self.craft, fates)
        return self.make(craft) if craft.wheels else self.whole

    def _signed(self, plan: Plan, monitor: WheelMonitor) -> Plan:
        """The plan with how many wheels have failed, for the recording."""
        failed = float(self.craft.wheels - len(monitor.sound))
        return replace(plan, signals={**plan.signals, "wheels_failed": failed})


def build_monitored(
    craft: Spacecraft, period: float, whole: Planner, make: Callable[[Spacecraft], Planner]
) -> MonitoredPlanner:
    """A planner with those of every single failure beside it."""
    nothing: Fates = (None,) * craft.wheels
    singles = [
        (*nothing[:i], fate, *nothing[i + 1 :])
        for i in range(craft.wheels)
        for fate in Fate
        if craft.wheels > 1
    ]
    prepared = {fates: make(reduced(craft, fates)) for fates in singles}
    return MonitoredPlanner(craft, period, whole, make, prepared)


def _for_all(belief: Belief | None, fates: Fates) -> Belief | None:
    """What was learned of the craft, with the friction of every wheel."""
    if belief is None or belief.friction is None:
        return belief
    return replace(belief, friction=widened(belief.friction, fates))
