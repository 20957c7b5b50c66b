"""The log: thinned it shows the same flight, and a flight of days costs the same every second."""

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import simsat
from simsat.control.ground.errors import DivergedError, SettingsError
from simsat.flight.loop import sense_truth
from simsat.mjcf import Model
from simsat.plant.log import WINDOW
from simsat.plant.plant import Plant

SENSORS = {"enabled": True, "delay_samples": 3}


@pytest.mark.parametrize(
    ("settings", "rows"),
    [
        ({"keep_s": 0.5}, 21),
        ({"keep_s": 2.0, "sensors": SENSORS}, 6),
        ({"keep_s": 0.15, "start": {"omega_deg_s": (2.0, 0.0, 1.0)}}, 67),
    ],
)
def test_a_thinned_log_shows_the_same_flight(settings: dict[str, Any], rows: int) -> None:
    shared = {key: value for key, value in settings.items() if key != "keep_s"}
    thin = simsat.fly(duration_s=10.0, **settings)
    full = simsat.fly(duration_s=10.0, **shared)
    stride = round(settings["keep_s"] / 0.05)
    assert thin.flight.plant.log.rows == rows
    np.testing.assert_allclose(thin.table["t_s"], full.table["t_s"].to_numpy()[::stride])
    for name in ("q_x", "omega_z", "wheel_speed_wheel_x", "torque_command_wheel_y",
                 "momentum_N_z", "torque_applied_wheel_x"):  # fmt: skip
        np.testing.assert_array_equal(thin.table[name], full.table[name].to_numpy()[::stride])
    for name in ("torque_command_wheel_x", "plan_status"):
        assert thin.steps[name].equals(full.steps[name])
    assert all(step.plan.evidence is None for step in thin.flight.steps)


def test_residuals_are_stated_where_the_log_has_the_ends_of_periods() -> None:
    full = simsat.fly(duration_s=5.0).steps["torque_residual_wheel_x"].to_numpy()
    within = simsat.fly(duration_s=5.0, keep_s=0.25).steps["torque_residual_wheel_x"].to_numpy()
    np.testing.assert_array_equal(within, full)
    without = simsat.fly(duration_s=5.0, keep_s=1.0).steps["torque_residual_wheel_x"].to_numpy()
    assert np.isnan(without).all()


def test_the_newest_samples_stay_at_hand_when_the_window_rolls(two_wheel: Model) -> None:
    ticks = 2 * WINDOW + 100
    thin, full = (Plant(two_wheel, 0.05, ticks, keep=keep) for keep in (100, 1))
    for plant in (thin, full):
        plant.reset(np.array([1.0, 0, 0, 0]), np.array([0.01, -0.02, 0.03]), np.array([90.0, -40]))
        for _ in range(ticks // 10):
            plant.advance(np.array([1e-4, -2e-4]), 10)
            mine, whole = plant.recent(20), full.recent(20)
            assert mine.t[-1] == pytest.approx(plant.t)
        if plant is full:
            for name in ("t", "q", "omega", "wheel_speed", "torque"):
                np.testing.assert_array_equal(getattr(thin.recent(99), name),
                                              getattr(full.recent(99), name))  # fmt: skip
            np.testing.assert_array_equal(thin.attitudes, full.attitudes[::100])
            np.testing.assert_array_equal(thin.log.t, full.log.t[::100])
            assert thin.sampled == full.sampled == ticks + 1 - ticks % 10
            assert whole is not None


def test_a_divergence_ends_both_logs_before_it(two_wheel: Model) -> None:
    plant = Plant(two_wheel, 0.05, 100, keep=4)
    plant.reset(np.array([1.0, 0, 0, 0]))
    plant.advance(np.zeros(2), 10)
    plant._d.qvel[:] = np.inf  # the tick that follows has no finite rate
    with pytest.raises(DivergedError, match=r"at t = 0\.55 s"):
        plant.advance(np.zeros(2), 10)
    assert plant.sampled == 11
    np.testing.assert_allclose(plant.log.t, [0.0, 0.2, 0.4])


def allocated(plant: Plant) -> int:
    """Bytes that sensing once takes at most."""
    tracemalloc.start()
    sense_truth(plant, 10, np.zeros(2))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


@pytest.mark.parametrize("keep", [1, 20])
def test_sensing_costs_the_same_however_long_the_flight_has_been(
    two_wheel: Model, keep: int
) -> None:
    """It copied the whole log at each control instant: 10,000 s took 51 s in place of 30."""
    plant = Plant(two_wheel, 0.05, 8_000, keep=keep)
    plant.reset(np.array([1.0, 0, 0, 0]))
    plant.advance(np.zeros(2), 100)
    early = allocated(plant)
    for _ in range(8):
        plant.advance(np.zeros(2), 950)
    assert allocated(plant) < 2 * early


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"keep_s": 0.07}, r"--keep-s in --sample-s: 0\.07 s is not a whole number of 0\.05 s"),
        ({"keep_s": 0.0}, r"--keep-s is 0: give a finite number above 0"),
        ({"duration_s": 1e9, "keep_s": 10.0}, r"of --keep-s 10 s make 1e\+08 samples, more than"),
        ({"keep_s": 1.0, "sensors": {"delay_samples": 3000}, "duration_s": 200.0},
         "leave out --keep-s"),
    ],
)  # fmt: skip
def test_a_rate_that_cannot_be_kept_is_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        simsat.prepare_mission(**settings)


def test_a_recording_holds_what_is_kept(tmp_path: Path) -> None:
    from rerun.chunk import RrdReader

    result = simsat.fly("two_wheel", duration_s=10.0, keep_s=2.0)
    result.record(tmp_path / "thin.rrd")
    sizes: dict[str, int] = {}
    for chunk in RrdReader(tmp_path / "thin.rrd").stream():
        path = str(chunk.entity_path)
        sizes[path] = sizes.get(path, 0) + chunk.to_record_batch().num_rows
    assert sizes["/signals/rate"] == 6 + 1  # and the names of its curves
    assert sizes["/planner/time"] == 5 + 1
