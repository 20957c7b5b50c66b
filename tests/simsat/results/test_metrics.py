"""The metrics on made-up flights whose answers are known."""

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.flight.loop import Ending, Flight
from simsat.mjcf import Model
from simsat.plant.plant import Plant
from simsat.results.metrics import judge, settling_sample


def flight_with_errors(model: Model, errors_deg: np.ndarray) -> Flight:
    plant = Plant(model, 0.05, len(errors_deg) - 1)
    plant.reset(attitude.IDENTITY)
    plant.log.rows = len(errors_deg)
    plant.log.qpos[:, 3:7] = attitude.from_axis_angle(np.array([0, 0, 1.0]), np.radians(errors_deg))
    return Flight(plant, 10)


def test_settling_is_the_start_of_the_stretch_that_lasts() -> None:
    assert settling_sample(np.array([3.0, 0.4, 0.6, 0.4, 0.3])) == 3
    assert settling_sample(np.array([0.1, 0.2])) == 0
    assert settling_sample(np.array([0.1, 0.5])) is None  # below, not at
    assert settling_sample(np.array([0.1, np.nan])) is None


def test_errors_of_a_converged_flight(two_wheel: Model) -> None:
    errors = np.array([90.0, 0.4, 2.0, 0.3, 0.4, 0.0])
    metrics = judge(flight_with_errors(two_wheel, errors), attitude.IDENTITY)
    assert metrics["converged"] is True
    assert metrics["settling_time_s"] == pytest.approx(0.15)
    assert metrics["steady_state_rmse_deg"] == pytest.approx(np.sqrt((0.3**2 + 0.4**2) / 3))
    assert metrics["final_error_deg"] == pytest.approx(0.0, abs=1e-12)


def test_a_flight_that_does_not_converge_keeps_its_final_error(two_wheel: Model) -> None:
    metrics = judge(flight_with_errors(two_wheel, np.array([90.0, 0.4, 0.7])), attitude.IDENTITY)
    assert metrics["converged"] is False
    assert metrics["settling_time_s"] is None
    assert metrics["steady_state_rmse_deg"] is None
    assert metrics["final_error_deg"] == pytest.approx(0.7)


def test_a_flight_that_was_broken_off_has_not_converged(two_wheel: Model) -> None:
    flight = flight_with_errors(two_wheel, np.array([90.0, 0.1, 0.1]))
    flight.ending, flight.reason = Ending.DIVERGED, "the simulation diverged at t = 0.10 s"
    metrics = judge(flight, attitude.IDENTITY)
    assert metrics["converged"] is False
    assert metrics["ending"] == "diverged"
    assert "t = 0.10 s" in metrics["reason"]


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
