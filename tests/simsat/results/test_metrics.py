"""The metrics on made-up flights whose answers are known."""

from pathlib import Path

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.flight.loop import Ending, Flight
from simsat.mjcf import Model
from simsat.plant.plant import Plant
from simsat.replay import ReplaySettings, prepare_replay
from simsat.results.metrics import MINIMUM_STAY, judge, settling_sample
from simsat.results.summary import result_table

TICK_S = 0.05
STAY = round(MINIMUM_STAY / TICK_S)  # samples after the first


def flight_with_errors(model: Model, errors_deg: np.ndarray) -> Flight:
    plant = Plant(model, TICK_S, len(errors_deg) - 1)
    plant.reset(attitude.IDENTITY)
    plant.log.rows = len(errors_deg)
    plant.log.qpos[:, 3:7] = attitude.from_axis_angle(np.array([0, 0, 1.0]), np.radians(errors_deg))
    return Flight(plant, 10)


def staying(*errors_deg: float) -> np.ndarray:
    """These errors, the last one kept just so long that a flight counts as converged."""
    return np.concatenate([errors_deg, np.full(STAY, errors_deg[-1])])


def test_settling_is_the_start_of_the_stretch_that_lasts(two_wheel: Model) -> None:
    def settled(*errors: float) -> int | None:
        return settling_sample(flight_with_errors(two_wheel, staying(*errors)), staying(*errors))

    assert settled(3.0, 0.4, 0.6, 0.4) == 3
    assert settled(0.1) == 0
    assert settled(0.1, 0.5) is None  # below, not at
    assert settled(0.1, np.nan) is None


def test_a_stay_counts_from_its_first_sample_below(two_wheel: Model) -> None:
    """The least stay that counts, wherever round-off puts its ends, and one sample less."""
    for before in range(200):
        errors = np.concatenate([np.full(before, 3.0), staying(0.2)])
        assert judge(flight_with_errors(two_wheel, errors), attitude.IDENTITY)["converged"]
        shorter = flight_with_errors(two_wheel, errors[:-1])
        assert not judge(shorter, attitude.IDENTITY)["converged"]
    metrics = judge(shorter, attitude.IDENTITY)
    assert metrics["convergence"] == "below 0.5 deg only for the last 4.95 s; 5 s are needed"
    assert "converged          no: below 0.5 deg only for" in result_table(metrics)


def test_the_stay_that_is_needed_can_be_told(two_wheel: Model) -> None:
    flight = flight_with_errors(two_wheel, np.array([90.0, 0.4, 2.0, 0.3, 0.4, 0.0]))
    assert judge(flight, attitude.IDENTITY, stay_s=0.1)["settling_time_s"] == pytest.approx(0.15)
    assert judge(flight, attitude.IDENTITY, stay_s=0.15)["convergence"] == (
        "below 0.5 deg only for the last 0.10 s; 0.15 s are needed"
    )


def test_what_drifts_through_the_target_has_not_converged(tmp_path: Path) -> None:
    """A replay that nobody steers: 1 deg/s from -8.2 deg, 8 s long."""
    profile, start = tmp_path / "passby.npz", np.radians(-8.2)
    turn = np.array([0.0, 0.0, 1.0])
    np.savez(
        profile, u=np.zeros((16, 2)), dt_u=0.5,
        q0=attitude.from_axis_angle(turn, start), w0=np.radians(1.0) * turn,
    )  # fmt: skip
    mission = prepare_replay(ReplaySettings(profile))
    metrics = judge(mission.fly(), mission.target)
    assert metrics["final_error_deg"] == pytest.approx(0.2, abs=0.01)
    assert metrics["converged"] is False
    assert metrics["settling_time_s"] is None
    assert metrics["steady_state_rmse_deg"] is None
    assert metrics["convergence"] == "below 0.5 deg only for the last 0.25 s; 5 s are needed"


def test_errors_of_a_converged_flight(two_wheel: Model) -> None:
    errors = staying(90.0, 0.4, 2.0, 0.3, 0.4, 0.0)
    metrics = judge(flight_with_errors(two_wheel, errors), attitude.IDENTITY)
    assert metrics["converged"] is True
    assert metrics["convergence"] == "settled at t = 0.15 s"
    assert metrics["settling_time_s"] == pytest.approx(0.15)
    rmse = np.sqrt((0.3**2 + 0.4**2) / (3 + STAY))
    assert metrics["steady_state_rmse_deg"] == pytest.approx(rmse)
    assert metrics["final_error_deg"] == pytest.approx(0.0, abs=1e-12)


def test_a_flight_that_does_not_converge_keeps_its_final_error(two_wheel: Model) -> None:
    metrics = judge(flight_with_errors(two_wheel, np.array([90.0, 0.4, 0.7])), attitude.IDENTITY)
    assert metrics["converged"] is False
    assert metrics["convergence"] == "0.7 deg at the end, not below 0.5 deg"
    assert metrics["settling_time_s"] is None
    assert metrics["steady_state_rmse_deg"] is None
    assert metrics["final_error_deg"] == pytest.approx(0.7)


def test_a_flight_that_was_broken_off_has_not_converged(two_wheel: Model) -> None:
    flight = flight_with_errors(two_wheel, staying(90.0, 0.1))
    flight.ending, flight.reason = Ending.DIVERGED, "the simulation diverged at t = 5.05 s"
    metrics = judge(flight, attitude.IDENTITY)
    assert metrics["converged"] is False
    assert metrics["convergence"] == "broken off at t = 5.05 s"
    assert metrics["ending"] == "diverged"
    assert "t = 5.05 s" in metrics["reason"]


def test_limit_violations_are_counted(two_wheel: Model) -> None:
    flight = flight_with_errors(two_wheel, np.zeros(4))
    flight.plant.log.torque[:4, 0] = [0.0, 0.02, 0.041, 0.0501]  # Nm; 0.02 Nm per 50 ms is allowed
    flight.plant.log.qvel[2, -1] = -6001 * 2 * np.pi / 60  # rad/s
    metrics = judge(flight, attitude.IDENTITY)
    assert metrics["limit_violations"] == {"torque": 1, "torque_rate": 1, "wheel_speed": 1}
    assert metrics["peak_wheel_speed_rpm"] == pytest.approx(6001)
    assert metrics["peak_torque_Nm"] == pytest.approx(0.0501)


def test_a_drive_that_cuts_its_torque_at_the_speed_limit_breaks_no_limit(two_wheel: Model) -> None:
    plant = Plant(two_wheel, 0.05, 400)
    plant.reset(attitude.IDENTITY)
    plant.advance(np.array([0.05, 0.0]), 400)  # 20 s; the limit comes at 18
    metrics = judge(Flight(plant, 10), attitude.IDENTITY)
    assert metrics["peak_wheel_speed_rpm"] == pytest.approx(6000, rel=1e-6)
    assert sum(metrics["limit_violations"].values()) == 0
