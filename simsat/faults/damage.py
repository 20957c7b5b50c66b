"""The faults that are the plant's, as events at the start of a tick."""

from simsat.faults.fault import Fault, Kind
from simsat.mjcf import Model
from simsat.plant.damage import (
    Event,
    Happening,
    add_friction,
    hold_rod,
    refuse_impossible,
    scale_inertia,
    seize,
    weaken,
)


def plant_events(faults: tuple[Fault, ...], model: Model, tick: float) -> tuple[Event, ...]:
    """What happens to the plant, in order; times to the nearest tick.

    Raises `SettingsError` for an inertia that no body has.
    """
    events: list[Event] = []
    for fault in faults:
        first, last = _ticks(fault, tick)
        names = model.spacecraft.wheel_names
        if fault.kind is Kind.INERTIA:
            refuse_impossible(model, fault.values)
            events.append(Event(first, scale_inertia(fault.values)))
        elif fault.kind is Kind.SEIZE:
            events.append(Event(first, seize(names.index(fault.part))))
        elif fault.kind in (Kind.DEAD, Kind.WEAK):
            share = fault.values[0] if fault.values else 0.0
            wheel = names.index(fault.part)
            events += _while(first, last, weaken(wheel, share), weaken(wheel, 1.0))
        elif fault.kind is Kind.FRICTION:
            wheel, torque = names.index(fault.part), fault.values[0]
            events += _while(first, last, add_friction(wheel, torque), add_friction(wheel, -torque))
        elif fault.kind is Kind.ON:
            rod = model.spacecraft.rods.names.index(fault.part)
            largest = float(model.spacecraft.rods.dipole_max[rod])
            events += _while(first, last, hold_rod(rod, largest), hold_rod(rod, None))
    return tuple(sorted(events, key=lambda event: event.tick))


def _ticks(fault: Fault, tick: float) -> tuple[int, int | None]:
    last = None if fault.end == float("inf") else round(fault.end / tick)
    return round(fault.start / tick), last


def _while(first: int, last: int | None, begin: Happening, end: Happening) -> list[Event]:
    begun = Event(first, begin)
    return [begun] if last is None else [begun, Event(last, end)]
