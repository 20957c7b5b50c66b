from dataclasses import dataclass, replace

import numpy as np
import pytest

from simsat.control.correction.corrector import CorrectionSettings, ResidualCorrector
from simsat.control.correction.features import feature_count, features
from simsat.control.ground.arrays import Array, WheelVector
from simsat.control.ground.attitude import IDENTITY, from_axis_angle
from simsat.control.ground.errors import SettingsError
from simsat.control.interface.measurement import History, Measurement
from simsat.control.interface.plan import Plan
from simsat.control.model.ramp import ramped_torques
from simsat.control.model.rates import build_rate_model, predict_rate
from simsat.control.nmpc.planner import PlanStatus
from simsat.flight.mission import prepare
from simsat.learning.correction.windows import Telemetry, cut
from simsat.learning.sequence import self_fed
from simsat.mjcf.shipped import MODELS
from simsat.networks.correction import find_network, read_network
from simsat.settings import FlightSettings

PLAN = Plan(np.array([0.01, -0.02]), PlanStatus.OPTIMAL)


@dataclass(frozen=True)
class Says:
    answer: WheelVector

    def estimate(
        self, measurement: Measurement, torque: WheelVector, previous: WheelVector
    ) -> WheelVector:
        return self.answer + previous


def measured(error_deg: float) -> Measurement:
    q = from_axis_angle(np.array([0.0, 0.6, 0.8]), np.radians(error_deg))
    none = np.zeros(2)
    return Measurement(
        0.0,
        q,
        np.array([0.0, 0.0, 0.0]),
        none,
        none,
        History(none[:1], np.array([[0.0, 0.0, 0.0]]), none[None]),
    )


def test_the_correction_is_clipped_and_the_estimate_is_not() -> None:
    corrector = ResidualCorrector(Says(np.array([0.02, -0.001])), CorrectionSettings(), IDENTITY)
    correction, memory = corrector.correct(measured(90.0), PLAN, None)
    assert correction.torque.tolist() == [0.015, -0.001]
    assert correction.estimate.tolist() == [0.02, -0.001]
    again, _ = corrector.correct(measured(90.0), PLAN, memory)
    assert again.estimate.tolist() == [0.04, -0.002]  # the previous estimate comes back


def test_it_is_off_below_one_degree_until_it_is_beyond_one_point_three() -> None:
    corrector = ResidualCorrector(Says(np.array([0.01, 0.01])), CorrectionSettings(), IDENTITY)
    memory, active = None, []
    for error in (2.0, 1.1, 0.9, 1.1, 1.4, 1.1):
        correction, memory = corrector.correct(measured(error), PLAN, memory)
        active.append(correction.active)
        assert np.any(correction.torque) == correction.active
        assert np.any(correction.estimate)
    assert active == [True, True, False, False, True, True]


def test_a_limit_of_nothing_is_refused() -> None:
    with pytest.raises(SettingsError, match=r"limit-Nm is 0: give a finite number above 0"):
        CorrectionSettings(limit_Nm=0.0)


@pytest.mark.parametrize("name", ["two_wheel", "two_wheel_friction"])
def test_the_oracle_makes_the_craft_move_as_planned(name: str) -> None:
    """The sign and size of the correction: with it, the true plant's rates one period ahead are
    those that the nominal model predicts for the plan alone, on the wheel axes."""
    settings = FlightSettings(model=MODELS / name / f"{name}.xml", controller="nmpc-oracle")
    mission = prepare(settings)
    assert mission.pilot is not None
    corrector, plant = mission.pilot.corrector, mission.build_plant()
    believed = build_rate_model(mission.believed, False)
    rate_max = mission.believed.torque_rate_max
    assert corrector is not None
    alone: list[Array] = []
    corrected: list[Array] = []
    for k in range(12):
        random = np.random.default_rng(k)
        omega = 0.05 * random.standard_normal(3)
        speed = 40.0 * random.choice([-1.0, 1.0], 2) + 10.0 * random.standard_normal(2)
        plan = Plan(random.uniform(-0.03, 0.03, 2), PlanStatus.OPTIMAL)
        state = measured(60.0)
        state = replace(state, omega=omega, wheel_speed=speed)
        correction, _ = corrector.correct(state, plan, None)
        none = np.zeros(2)
        torques = ramped_torques(plan.torque, none, rate_max, 0.5)
        expected = predict_rate(believed, omega, speed, torques, np.zeros(3), 0.5)
        for share, misses in ((0.0, alone), (1.0, corrected)):
            plant.reset(state.q, omega, speed)
            plant.advance(plan.torque + share * correction.torque, 10)
            misses.append((plant.state().omega - expected)[:2])
    assert np.sqrt(np.mean(np.square(corrected))) < 0.15 * np.sqrt(np.mean(np.square(alone)))


def test_sixteen_inputs_for_two_wheels() -> None:
    random = np.random.default_rng(1)
    previous, torque = random.standard_normal((2, 5, 2))
    omega, before = random.standard_normal((2, 5, 3))
    J = np.diag([1.5, 1.6, 1.2])
    x = features(previous, omega, before, 0.05, torque, J)
    assert x.shape == (5, feature_count(2)) == (5, 16)
    for row in range(5):
        one = features(previous[row], omega[row], before[row], 0.05, torque[row], J)
        assert np.array_equal(one, x[row])
        acceleration = (omega[row] - before[row]) / 0.05
        spin = np.cross(omega[row], J @ omega[row])
        by_hand = [*previous[row], *omega[row], *before[row], *acceleration, *torque[row], *spin]
        assert np.allclose(x[row], by_hand, rtol=1e-12)


def test_flight_and_training_give_the_network_the_same_inputs() -> None:
    """The estimates along a flight are those that training's own windows of it lead to."""
    mission = prepare(FlightSettings(controller="nmpc-pinn", duration_s=10.0))
    flight = mission.fly()
    plant, believed = flight.plant, build_rate_model(mission.believed, False)
    plans = np.array([step.plan.torque for step in flight.steps])
    telemetry = Telemetry(plant.tick, plant.rates, plant.wheel_speeds, plans)
    windows = cut([telemetry], 0.5, believed, mission.believed.torque_rate_max)
    path = find_network("pinn", mission.settings.model)
    network = read_network(path, mission.model.spacecraft, mission.believed, False)
    flown = [step.correction.estimate for step in flight.steps if step.correction]
    assert np.allclose(self_fed(network, windows, believed)[0], flown, rtol=1e-9, atol=1e-12)
