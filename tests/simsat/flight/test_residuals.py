import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.model.rates import build_rate_model
from simsat.flight.mission import prepare
from simsat.flight.residuals import true_residuals
from simsat.learning.correction.windows import Telemetry, cut
from simsat.settings import FlightSettings, NominalSettings


def flown(mismatch: float) -> Array:
    settings = FlightSettings(duration_s=8.0, nominal=NominalSettings(mismatch=mismatch))
    mission = prepare(settings)
    flight = mission.fly()
    return true_residuals(flight, build_rate_model(mission.believed, False))


def test_a_right_belief_misses_only_the_environment_and_the_drives_steps() -> None:
    residuals = flown(mismatch=0.0)
    assert residuals.shape == (16, 2)
    assert np.abs(residuals).max() < 2e-5  # Nm; the drive ends its ramps at whole 10 ms


def test_a_belief_twice_as_wrong_misses_about_twice_as_much() -> None:
    once = flown(mismatch=1.0)
    twice = flown(mismatch=2.0)
    first = slice(0, 3)  # later the two flights differ
    ratio = np.abs(twice[first]).sum() / np.abs(once[first]).sum()
    assert 1.5 < ratio < 3.0


def test_it_is_what_training_learns_from() -> None:
    mission = prepare(FlightSettings(duration_s=8.0))
    flight = mission.fly()
    believed = build_rate_model(mission.believed, False)
    plant = flight.plant
    telemetry = Telemetry(plant.tick, plant.rates, plant.wheel_speeds, np.array(flight.commands))
    windows = cut([telemetry], 0.5, believed, mission.believed.torque_rate_max)
    residuals = true_residuals(flight, believed)
    assert np.allclose(residuals, windows.residual[0], rtol=1e-12, atol=1e-15)
    assert np.array_equal(true_residuals(flight, believed, first=10), residuals[10:])


def test_a_period_cut_short_has_no_residual() -> None:
    mission = prepare(FlightSettings(duration_s=8.0))
    flight = mission.fly()
    flight.plant.log.rows -= 3
    assert len(true_residuals(flight, build_rate_model(mission.believed, False))) == 15
