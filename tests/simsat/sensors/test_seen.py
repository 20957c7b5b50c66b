"""Flights on instruments: what the controller saw stands beside the truth, and garbage does not
get through the filter."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.estimator.mekf import Mekf
from simsat.control.ground.arrays import WheelVector
from simsat.control.ground.attitude import error_angle
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.measurement import Fix, Measurement
from simsat.flight.loop import Flight, fly
from simsat.flight.mission import Mission, prepare
from simsat.results.flight_result import FlightResult
from simsat.results.metrics import error_deg
from simsat.sensors.settings import SensorSettings
from simsat.settings import FlightSettings
from tests.door_cases import numbers_in


def mission(preset: Any = "smallsat", **changes: Any) -> Mission:
    sensors = SensorSettings(preset=preset, seed=2)
    return prepare(FlightSettings(controller="nmpc-learned", sensors=sensors, **changes))


def knowledge_deg(flight: Flight) -> np.ndarray:
    rows = flight.ticks_per_period * np.arange(len(flight.steps))
    q = np.array([step.seen.q for step in flight.steps if step.seen is not None])
    return np.degrees(error_angle(flight.plant.attitudes[rows], q))


@pytest.mark.parametrize(("preset", "blackout_deg", "end_deg"), [
    ("cubesat", 0.6, 0.06), ("smallsat", 0.25, 0.012), ("highend", 0.05, 0.0015),
])  # fmt: skip
def test_a_slew_through_the_blackout_converges(
    preset: str, blackout_deg: float, end_deg: float
) -> None:
    flight = mission(preset, duration_s=50.0).fly()
    off = knowledge_deg(flight)
    assert max(step.estimator["blackout_s"] for step in flight.steps) > 10.0
    assert off.max() < blackout_deg
    assert np.sqrt(np.mean(off[-20:] ** 2)) < end_deg
    assert error_deg(flight, np.array([1.0, 0.0, 0.0, 0.0]))[-200:].max() < 0.5


def test_without_the_filter_the_last_fix_loses_the_craft() -> None:
    flight = mission("smallsat", estimator="none", duration_s=50.0).fly()
    assert error_deg(flight, np.array([1.0, 0.0, 0.0, 0.0]))[-200:].min() > 0.5


@pytest.mark.parametrize("controller", ["nmpc", "nmpc-pinn", "nmpc-pinn-supervisor"])
def test_every_controller_is_told_what_the_filter_says(controller: str) -> None:
    changed = FlightSettings(
        controller=controller, angle_deg=30.0, duration_s=4.0,
        sensors=SensorSettings(preset="smallsat"),
    )  # fmt: skip
    flight = prepare(changed).fly()
    assert knowledge_deg(flight).max() < 0.05


def test_tables_hold_what_was_seen_with_units() -> None:
    result = simsat.fly("two_wheel", duration_s=3.0, sensors={"preset": "smallsat"})
    table = result.steps
    seen = np.stack([table[f"seen_omega_{axis}"].to_numpy() for axis in "xyz"], axis=1)
    truth = result.flight.plant.rates[:: result.flight.ticks_per_period][: len(seen)]
    assert 0.0 < np.abs(seen - truth).max() < np.radians(0.1)
    assert table.schema.field("seen_omega_x").metadata[b"unit"] == b"rad/s"
    assert table["seen_error_deg"].to_numpy().max() < 0.05
    assert "estimator_attitude_deviation_arcsec" in table.column_names
    plain = simsat.fly("two_wheel", duration_s=1.0).steps
    assert not [name for name in plain.column_names if name.startswith(("seen", "estimator"))]


def test_a_recording_shows_what_was_seen(tmp_path: Path) -> None:
    from rerun.chunk import RrdReader

    result = simsat.fly("two_wheel", duration_s=3.0, sensors={"preset": "smallsat"})
    path = result.record(tmp_path / "flight.rrd")
    paths = {str(chunk.entity_path) for chunk in RrdReader(path).stream()}
    assert {"/sensors/attitude_error_deg", "/sensors/attitude_deviation_arcsec"} <= paths


def test_the_truth_needs_no_filter_and_says_so() -> None:
    with pytest.raises(SettingsError, match="--estimator mekf has nothing to filter"):
        prepare(FlightSettings(estimator="mekf"))


def damaged(flown: Mission, damage: Any, periods: range) -> tuple[Flight, list[Any]]:
    """A flight whose measurements are damaged in some periods, and what the filter remembers."""
    instants, timelines = 0, []
    pilot = flown.pilot
    assert pilot is not None
    assert isinstance(pilot.estimator, Mekf)

    class Noted(Mekf):
        def estimate(self, measurement: Measurement, timeline: Any) -> Any:
            out = super().estimate(measurement, timeline)
            timelines.append(out[1])
            return out

    def sense(plant: Any, samples: int, torque: WheelVector) -> Measurement:
        nonlocal instants
        instants += 1
        told = flown.sense(plant, samples, torque)
        return damage(told) if instants - 1 in periods else told

    noted = replace(pilot, estimator=Noted(pilot.estimator.gyro))
    flight = fly(flown.build_plant(), noted, flown.periods, flown.ticks_per_period, sense)
    return flight, timelines


def bad_fix(told: Measurement) -> Measurement:
    """Whatever could be wrong of a fix, at once."""
    q, P = np.array([1.0, 0.0, 0.0, 0.0]), 1e-9 * np.eye(3)
    bad = (
        Fix(told.t, np.nan * q, P), Fix(told.t, 0.0 * q, P), Fix(np.nan, q, P),
        Fix(told.t + 5.0, q, P), Fix(told.t, q, np.nan * P), Fix(told.t, q, -P),
        Fix(told.t, q[:3], P), Fix(-1e300, q, P),
    )  # fmt: skip
    return replace(told, fixes=(*bad, *told.fixes))


def test_bad_fixes_are_left_out_and_the_good_one_counts() -> None:
    flown = mission(duration_s=12.0)
    plain, _ = damaged(flown, lambda told: told, range(0))
    spoilt, _ = damaged(flown, bad_fix, range(24))
    np.testing.assert_array_equal(plain.plant.attitudes, spoilt.plant.attitudes)


def test_periods_of_garbage_leave_nothing_in_the_filter() -> None:
    def nothing(told: Measurement) -> Measurement:
        return replace(told, omega=np.nan * told.omega)

    flown = mission(duration_s=30.0)
    flight, timelines = damaged(flown, nothing, range(6, 10))
    assert [step.refusal is not None for step in flight.steps][5:11] == [
        False, True, True, True, True, False,
    ]  # fmt: skip
    for timeline in timelines:
        for place, numbers in numbers_in(timeline):
            assert np.isfinite(numbers).all(), place
    result = FlightResult(flown, flight)
    assert result.steps["seen_error_deg"].null_count == 0
    assert np.isnan(result.steps["seen_error_deg"].to_numpy()).sum() == 4
