"""Flights whose sensors go wrong for a while, instant by instant, with the memories in sight."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.interface.measurement import Measurement
from simsat.flight.loop import Instant, Memories, Step, sense_truth, take
from simsat.flight.mission import Mission, prepare
from simsat.results.metrics import error_deg
from simsat.settings import FlightSettings

Damage = Callable[[Measurement], Measurement]

PILOTS = {
    "nmpc": {"controller": "nmpc"},
    "nmpc-pinn": {"controller": "nmpc-pinn"},
    "nmpc-pinn-supervisor, faithful": {
        "controller": "nmpc-pinn-supervisor",
        "supervisor": "faithful",
    },
    "nmpc-pinn-supervisor, sound": {"controller": "nmpc-pinn-supervisor", "supervisor": "sound"},
    "nmpc-pinn-supervisor, value": {"controller": "nmpc-pinn-supervisor", "supervisor": "value"},
    "nmpc-learned": {"controller": "nmpc-learned"},
    "nmpc-oracle": {"controller": "nmpc-oracle"},
}


@lru_cache(maxsize=len(PILOTS))
def mission_of(pilot: str, duration_s: float = 100.0) -> Mission:
    """A slew of 75 degrees under one of the pilots."""
    settings: dict[str, Any] = PILOTS[pilot]
    return prepare(FlightSettings(duration_s=duration_s, angle_deg=75.0, **settings))


@dataclass(frozen=True)
class Flown:
    """What became of it."""

    steps: tuple[Step, ...]
    memories: tuple[Memories, ...]
    """After every instant."""
    error_deg: Array
    """At every sample."""


def flown_with(mission: Mission, damage: Damage, instants: range, periods: int) -> Flown:
    """A flight whose measurements are damaged at some instants."""
    plant, ticks = mission.build_plant(), mission.ticks_per_period
    pilot, craft = mission.pilot, mission.model.spacecraft
    assert pilot is not None
    torque, memories = np.zeros(craft.wheels), Memories()
    steps: list[Step] = []
    remembered: list[Memories] = []
    for k in range(periods):
        sensed = sense_truth(plant, min(ticks, plant.sampled - 1), torque)
        seen = damage(sensed) if k in instants else sensed
        now = Instant(plant.state().t, ticks * plant.tick, torque)
        step, memories = take(pilot, seen, now, memories, craft)
        plant.advance(step.command, ticks)
        torque = step.command
        steps.append(step)
        remembered.append(memories)
    flight = mission_flight(mission, plant)
    return Flown(tuple(steps), tuple(remembered), error_deg(flight, mission.target))


def mission_flight(mission: Mission, plant: Any) -> Any:
    """The plant's log, as a flight that metrics can read."""
    from simsat.flight.loop import Flight

    return Flight(plant, mission.ticks_per_period)


def numbers_in(value: Any, place: str = "") -> Iterator[tuple[str, Array]]:
    """Every number that a memory holds, with where it stands."""
    if is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            yield from numbers_in(getattr(value, field.name), f"{place}.{field.name}")
    elif isinstance(value, Mapping):
        for name, inner in value.items():
            yield from numbers_in(inner, f"{place}[{name}]")
    elif isinstance(value, (tuple, list)):
        for k, inner in enumerate(value):
            yield from numbers_in(inner, f"{place}[{k}]")
    elif isinstance(value, (float, np.ndarray, np.floating)):
        yield place, np.asarray(value, float)


def spoilt(measurement: Measurement, name: str, component: int, value: float) -> Measurement:
    """One component of one quantity replaced; `history.NAME` is its newest sample."""
    if name.startswith("history."):
        history, inner = measurement.history, name.removeprefix("history.")
        rows = getattr(history, inner).copy()
        rows[-1 if rows.ndim == 1 else (-1, component % rows.shape[1])] = value
        return replace(measurement, history=replace(history, **{inner: rows}))
    if name == "t":
        return replace(measurement, t=value)
    numbers = getattr(measurement, name).copy()
    numbers[component % len(numbers)] = value
    return replace(measurement, **{name: numbers})
