"""The loop: what it asks of each layer, and how a flight ends."""

import gc
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.interface.layers import Correction, Pilot
from simsat.control.interface.measurement import Measurement
from simsat.control.interface.plan import Plan
from simsat.control.interface.verdict import Decision, Reason, Verdict
from simsat.control.nmpc.planner import PlanStatus
from simsat.flight.loop import SOLVER_PATIENCE, Ending, Flight, fly, undisturbed
from simsat.flight.mission import Mission, prepare
from simsat.mjcf import Model
from simsat.plant.plant import Plant
from simsat.settings import FlightSettings

SHORT = FlightSettings(duration_s=4.0)


@dataclass
class Constant:
    """A planner that always wants the same torque and notes what it was told."""

    torque: np.ndarray
    lost: bool = False

    def __post_init__(self) -> None:
        self.heard: list[Measurement] = []
        self.memories: list[Any] = []

    def plan(self, measurement: Measurement, memory: Any) -> tuple[Plan, Any]:
        self.heard.append(measurement)
        self.memories.append(memory)
        status = PlanStatus.DAMPING if self.lost else PlanStatus.OPTIMAL
        return Plan(self.torque, status, failed=self.lost), len(self.heard)


@dataclass
class Adding:
    torque: np.ndarray

    def correct(self, measurement: Measurement, plan: Plan, memory: Any) -> tuple[Correction, Any]:
        return Correction(self.torque, self.torque, True), None


@dataclass
class Sharing:
    alpha: float

    def supervise(
        self, measurement: Measurement, plan: Plan, correction: Correction, memory: Any
    ) -> tuple[Verdict, Any]:
        return Verdict(self.alpha, Decision.ATTENUATED, Reason.LIMITED, 0.0, 0.0, 0.0), None


def plant(model: Model, ticks: int = 2000) -> Plant:
    plant = Plant(model, 0.05, ticks)
    plant.reset(attitude.from_axis_angle(np.array([1.0, 0, 0]), 1.0))
    return plant


def test_the_planner_hears_truth_history_and_its_own_memory(two_wheel: Model) -> None:
    planner = Constant(np.array([0.01, -0.02]))
    flight = fly(plant(two_wheel), Pilot(planner), 3, 10)
    first, second = planner.heard[:2]
    assert first.t == 0.0
    assert len(first.history.t) == 1
    np.testing.assert_array_equal(first.torque, 0.0)
    assert second.t == pytest.approx(0.5)
    np.testing.assert_allclose(second.history.t, 0.05 * np.arange(11))
    np.testing.assert_array_equal(second.history.omega[-1], second.omega)
    np.testing.assert_array_equal(second.torque, planner.torque)
    assert planner.memories == [None, 1, 2]
    assert flight.held_commands().shape == (31, 2)
    assert flight.ending is Ending.COMPLETE


@pytest.mark.parametrize(("alpha", "share"), [(0.0, 0.0), (0.25, 0.25), (1.0, 1.0)])
def test_the_supervisor_scales_the_correction(two_wheel: Model, alpha: float, share: float) -> None:
    planned, added = np.array([0.01, -0.02]), np.array([0.004, 0.008])
    pilot = Pilot(Constant(planned), Adding(added), Sharing(alpha))
    flight = fly(plant(two_wheel), pilot, 2, 10)
    np.testing.assert_allclose(flight.commands[0], planned + share * added)


def test_a_rejected_correction_may_be_no_number(two_wheel: Model) -> None:
    pilot = Pilot(Constant(np.array([0.01, 0.0])), Adding(np.full(2, np.nan)), Sharing(0.0))
    flight = fly(plant(two_wheel), pilot, 2, 10)
    np.testing.assert_array_equal(flight.commands[0], [0.01, 0.0])


def test_an_unsupervised_sum_stays_inside_the_torque_limit(two_wheel: Model) -> None:
    pilot = Pilot(Constant(np.array([0.05, -0.05])), Adding(np.array([0.01, -0.01])))
    flight = fly(plant(two_wheel), pilot, 2, 10)
    np.testing.assert_array_equal(flight.commands[0], [0.05, -0.05])


def test_an_unsupervised_nan_is_left_out(two_wheel: Model) -> None:
    pilot = Pilot(Constant(np.array([0.01, 0.0])), Adding(np.full(2, np.nan)))
    flight = fly(plant(two_wheel), pilot, 2, 10)
    assert flight.ending is Ending.COMPLETE
    np.testing.assert_array_equal(flight.commands, [[0.01, 0.0]] * 2)


def test_a_plan_that_is_no_number_ends_the_flight_with_a_reason(two_wheel: Model) -> None:
    flight = fly(plant(two_wheel), Pilot(Constant(np.full(2, np.nan))), 5, 10)
    assert flight.ending is Ending.DIVERGED
    assert "the commanded torque [nan nan] Nm is not finite" in flight.reason
    assert np.isfinite(flight.plant.attitudes).all()


def test_a_lost_planner_ends_the_flight_with_its_last_words(two_wheel: Model) -> None:
    flight = fly(plant(two_wheel), Pilot(Constant(np.zeros(2), lost=True)), 200, 10)
    assert flight.ending is Ending.SOLVER_LOST
    assert len(flight.steps) == SOLVER_PATIENCE
    assert PlanStatus.DAMPING.value in flight.reason


def test_an_interrupted_flight_keeps_what_was_flown(two_wheel: Model) -> None:
    def stop(flight: Flight) -> None:
        if len(flight.steps) == 3:
            raise KeyboardInterrupt

    flight = fly(plant(two_wheel), Pilot(Constant(np.zeros(2))), 10, 10, watch=stop)
    assert flight.ending is Ending.INTERRUPTED
    assert flight.plant.log.rows == 31
    assert "t = 1.50 s" in flight.reason


def test_the_same_settings_fly_the_same_flight() -> None:
    logs = [flown(SHORT).plant.log for _ in range(2)]
    np.testing.assert_array_equal(logs[0].qpos, logs[1].qpos)


def flown(settings: FlightSettings) -> Flight:
    mission: Mission = prepare(settings)
    return mission.fly()


def test_a_target_elsewhere_is_the_same_problem_turned() -> None:
    """Without an environment only the attitude relative to the target matters."""
    still = replace(SHORT.environment, gravity_gradient=False, drag=False)
    settings = replace(SHORT, environment=still)
    turned = replace(settings, target=(0.5, -0.1, 0.7, 0.5))
    first, second = flown(settings), flown(turned)
    np.testing.assert_allclose(first.plant.torques, second.plant.torques, atol=1e-6)


def test_a_flight_is_not_searched_for_garbage_from_before_it() -> None:
    with undisturbed():
        assert gc.get_freeze_count() > 0
    assert gc.get_freeze_count() == 0
