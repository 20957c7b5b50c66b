"""Instruments that break, and flights in which anything does."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

import simsat
from simsat.control.ground.spacecraft import Spacecraft
from simsat.faults.fault import read_faults
from simsat.faults.senses import faulty
from simsat.flight.mission import prepare
from simsat.sensors.build import Span, build_suite
from simsat.sensors.settings import SensorSettings
from simsat.sensors.suite import Suite
from simsat.sensors.truth import TRUTH
from simsat.settings import FlightSettings
from tests.simsat.sensors.cases import ORBIT, ROWS, TICK, tumbling

ROWS_ALL = np.arange(ROWS)


def craft() -> Spacecraft:
    return tumbling().model.spacecraft


def broken(suite: Suite, *texts: str) -> Suite:
    return faulty(suite, read_faults(texts, craft()), craft(), TICK)


@pytest.mark.parametrize("preset", [None, "smallsat"])
def test_a_stuck_axis_repeats_what_it_read_and_the_others_go_on(preset: str | None) -> None:
    plant = tumbling()
    sound = build_suite(SensorSettings(preset=preset), Span(ROWS, TICK, 2, ORBIT))  # type: ignore[arg-type]
    read, good = (
        broken(sound, "gyro_y:stuck@5-10").gyro(plant, ROWS_ALL),
        sound.gyro(plant, ROWS_ALL),
    )
    assert (read[100:200, 1] == good[100, 1]).all()
    good[100:200, 1] = read[100:200, 1]
    np.testing.assert_array_equal(read, good)
    late = broken(sound, "gyro_y:stuck@5-10").gyro(plant, np.arange(150, 160))
    assert (late[:, 1] == read[100, 1]).all()


def test_a_bias_is_added_while_it_lasts() -> None:
    plant = tumbling()
    off = broken(TRUTH, "gyro_x:bias=0.5@5-10").gyro(plant, ROWS_ALL) - plant.rates
    np.testing.assert_allclose(off[100:200], [np.radians(0.5), 0.0, 0.0] * np.ones((100, 1)))
    assert (off[:100] == 0.0).all()
    assert (off[200:] == 0.0).all()


def test_a_tachometer_gets_stuck() -> None:
    plant = tumbling()
    name = craft().wheel_names[1]
    read = broken(TRUTH, f"{name}:tachometer@5").tachometers(plant, ROWS_ALL)
    assert (read[100:, 1] == plant.wheel_speeds[100, 1]).all()
    np.testing.assert_array_equal(read[:, 0], plant.wheel_speeds[:, 0])


def test_a_tracker_that_is_out_delivers_nothing_it_would_have_taken() -> None:
    plant = tumbling()
    settings = SensorSettings(
        preset="smallsat", figure=("tracker.rate-limit-deg-s=90", "tracker.sun-exclusion-deg=0",
                                   "tracker.earth-exclusion-deg=0"),
    )  # fmt: skip
    sound = build_suite(settings, Span(ROWS, TICK, 2, ORBIT))
    out = broken(sound, "tracker:out@5-10")
    kept = [fix.t for fix in out.attitudes.fixes(plant, ROWS_ALL)]
    all_of_them = [fix.t for fix in sound.attitudes.fixes(plant, ROWS_ALL)]
    assert kept == [t for t in all_of_them if not 5.0 - 1e-9 <= t < 10.0 - 1e-9]
    assert len(kept) < len(all_of_them)


def test_without_faults_the_instruments_are_the_sound_ones() -> None:
    assert broken(TRUTH) is TRUTH
    assert broken(TRUTH, "wheel_x:seize@4" if "wheel_x" in craft().wheel_names else
                  f"{craft().wheel_names[0]}:seize@4") is TRUTH  # fmt: skip
    assert prepare(FlightSettings()).sees_truth


def test_any_model_under_any_controller_flies_on_and_says_what_broke(tmp_path: Path) -> None:
    from rerun.chunk import RrdReader

    result = simsat.fly(
        "pyramid", controller="nmpc-learned", duration_s=8.0,
        fault=("wheel_1:seize@2", "gyro_x:bias=0.1@3-5"),
    )  # fmt: skip
    said = result.steps["faults"].to_pylist()
    assert said[3] == ""
    assert said[4] == "wheel_1 seize"
    assert said[6:10] == ["wheel_1 seize, gyro_x bias"] * 4
    assert said[10] == "wheel_1 seize"
    path = result.record(tmp_path / "flight.rrd")
    assert "/faults/acting" in {str(chunk.entity_path) for chunk in RrdReader(path).stream()}


def test_a_campaign_flies_the_faults(tmp_path: Path) -> None:
    folder = simsat.compare(
        ("nmpc",), "2", out=tmp_path / "campaign", workers=1, model="three_wheel", duration_s=3.0,
        fault=("wheel_z:seize@1",), recordings="none",
    )  # fmt: skip
    rows = pq.read_table(folder / "results.parquet").to_pylist()
    assert len(rows) == 2
    assert {row["ending"] for row in rows} == {"complete"}
    plain = simsat.fly("three_wheel", duration_s=3.0).metrics["final_error_deg"]
    assert all(abs(row["final_error_deg"] - plain) > 1e-3 for row in rows)


def test_a_rod_that_stays_on_keeps_its_largest_dipole_while_it_lasts() -> None:
    mission = simsat.prepare_mission("two_wheel_rods", controller="nmpc-learned", duration_s=8.0)
    name = mission.model.spacecraft.rods.names[0]
    largest = mission.model.spacecraft.rods.dipole_max[0]
    result = simsat.fly("two_wheel_rods", controller="nmpc-learned", duration_s=8.0,
                        fault=(f"{name}:on@3-5",))  # fmt: skip
    acted = result.flight.plant.dipoles[:, 0]
    assert (acted[61:101] == largest).all()
    assert acted[59] != largest
    assert acted[102] != largest
    told = result.steps[f"dipole_{name}"].to_numpy()
    assert told[7] != largest  # the controller doesn't know
