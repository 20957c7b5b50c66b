"""Whatever breaks and whatever is told, no NaN reaches a motor and no memory keeps any: for every
controller, on instruments and through the filter."""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simsat.control.interface.measurement import Fix, Measurement, Sighting
from simsat.faults.fault import read_faults
from simsat.flight.loop import Instant, Memories, take
from simsat.flight.mission import Mission, mission_sense, prepare
from simsat.sensors.settings import SensorSettings
from simsat.settings import FlightSettings
from tests.door_cases import PILOTS, numbers_in, spoilt

QUICK = settings(
    max_examples=4, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
THOROUGH = settings(QUICK, max_examples=40)
PERIODS = 14  # 7 s

ANYTHING = st.floats(allow_nan=True, allow_infinity=True)
PLACES = st.sampled_from(["t", "q", "omega", "wheel_speed", "history.t", "history.omega",
                          "history.wheel_speed"])  # fmt: skip
SPOILT = st.builds(
    lambda place, k, value: lambda told: spoilt(told, place, k, value),
    PLACES, st.integers(0, 3), ANYTHING,
)  # fmt: skip
ROW3 = st.tuples(ANYTHING, ANYTHING, ANYTHING).map(np.array)
FIXES = st.builds(
    lambda dt, q, c: lambda told: replace(
        told, fixes=(*told.fixes, Fix(told.t + dt, np.array(q), np.diag(c)))
    ),
    st.floats(-1.0, 0.1) | ANYTHING, st.tuples(ANYTHING, ANYTHING, ANYTHING, ANYTHING), ROW3,
)  # fmt: skip
SOUND_LOOKING = st.builds(  # a rotation, of a time and an error that could be: but wrong
    lambda dt, axis, c: lambda told: replace(
        told, fixes=(*told.fixes, Fix(told.t + dt, unit(axis), c * np.eye(3)))
    ),
    st.floats(-2.9, 0.0), st.tuples(*[st.floats(-1.0, 1.0)] * 4), st.floats(1e-14, 1.0),
)  # fmt: skip
SIGHTINGS = st.builds(
    lambda b, n, d: lambda told: replace(told, sightings=(Sighting(told.t, b, n, d),)),
    ROW3, ROW3, ANYTHING,
)  # fmt: skip
DAMAGE = st.one_of(SPOILT, FIXES, SOUND_LOOKING, SIGHTINGS)
FAULTS = st.lists(
    st.sampled_from([
        "tracker:out@1-4", "gyro_x:stuck@2", "gyro_y:bias=5@1-3", "gyro_z:bias=-0.2@0",
        "wheel_x:dead@2", "wheel_y:seize@3", "wheel_x:weak=0.2@1", "wheel_y:friction=0.01@2-5",
        "wheel_x:tachometer@1", "wheel_y:tachometer@4-5", "body:inertia=1.4@2",
    ]),
    max_size=3, unique_by=lambda text: text.partition(":")[0],
)  # fmt: skip


def unit(axis: tuple[float, ...]) -> np.ndarray:
    q = np.array(axis) + np.array([1e-3, 0.0, 0.0, 0.0])
    return q / np.linalg.norm(q)


@lru_cache(maxsize=len(PILOTS))
def mission_of(pilot: str) -> Mission:
    chosen: dict[str, Any] = PILOTS[pilot]
    sensors = SensorSettings(preset="smallsat", figure=("tracker.outlier-share=0.1",))
    return prepare(FlightSettings(duration_s=20.0, angle_deg=60.0, sensors=sensors, **chosen))


def nothing_poisons(pilot: str, damage: Any, window: range, faults: list[str]) -> None:
    mission = mission_of(pilot)
    craft = mission.model.spacecraft
    names = dict(zip(("wheel_x", "wheel_y"), craft.wheel_names, strict=True))
    texts = [
        names.get(t.partition(":")[0], t.partition(":")[0]) + t[t.index(":") :] for t in faults
    ]
    broken = read_faults(texts, craft)
    sense = mission_sense(mission.settings, mission.timing, broken, craft, mission.environment)
    mission = replace(mission, faults=broken, sense=sense)
    assert mission.pilot is not None
    plant, ticks = mission.build_plant(), mission.ticks_per_period
    torque, memories = np.zeros(craft.wheels), Memories()
    for k in range(PERIODS):
        told: Measurement = mission.sense(plant, min(ticks, plant.sampled - 1), torque)
        if k in window:
            told = damage(told)
        now = Instant(plant.state().t, ticks * plant.tick, torque)
        step, memories = take(mission.pilot, told, now, memories, craft)
        torque = step.command
        assert np.isfinite(torque).all()
        assert (np.abs(torque) <= craft.torque_max).all()
        places = [place for place, x in numbers_in(memories) if not np.isfinite(x).all()]
        assert not places
        plant.advance(torque, ticks)


@pytest.mark.parametrize("pilot", PILOTS)
@given(damage=DAMAGE, first=st.integers(0, 8), lasting=st.integers(1, 4), faults=FAULTS)
@QUICK
def test_nothing_poisons(pilot: str, damage: Any, first: int, lasting: int, faults: Any) -> None:
    nothing_poisons(pilot, damage, range(first, first + lasting), faults)


@pytest.mark.slow
@pytest.mark.parametrize("pilot", PILOTS)
@given(damage=DAMAGE, first=st.integers(0, 8), lasting=st.integers(1, 4), faults=FAULTS)
@THOROUGH
def test_nothing_poisons_whatever_it_is(
    pilot: str, damage: Any, first: int, lasting: int, faults: Any
) -> None:
    nothing_poisons(pilot, damage, range(first, first + lasting), faults)
