"""The networks that come with the models: still those of the models, and still good."""

import json
import time
from pathlib import Path

import numpy as np
import pytest

from simsat.control.model.rates import build_rate_model
from simsat.flight.mission import Mission, prepare
from simsat.learning.correction.data import start_attitude, starting_at
from simsat.learning.correction.report import wheel_axis_rms
from simsat.learning.correction.windows import Telemetry, Windows, cut
from simsat.learning.sequence import self_fed
from simsat.mjcf.shipped import MODELS
from simsat.networks.correction import read_network
from simsat.settings import FlightSettings

CUT = {"two_wheel": {"pinn": 0.95, "linear": 0.90}, "two_wheel_friction": {"pinn": 0.90}}


def unseen_flight(name: str) -> tuple[Mission, Windows]:
    """A flight whose start no training used: seeds of training are small."""
    base = FlightSettings(model=MODELS / name / f"{name}.xml", duration_s=30.0)
    mission = prepare(starting_at(base, start_attitude(1_000_000, 0)))
    flight = mission.fly()
    plant = flight.plant
    telemetry = Telemetry(plant.tick, plant.rates, plant.wheel_speeds, np.array(flight.commands))
    believed = build_rate_model(mission.believed, friction=False)
    return mission, cut([telemetry], 0.5, believed, mission.believed.torque_rate_max)


def shipped(name: str, network: str) -> Path:
    return MODELS / name / "network" / f"{network}.safetensors"


@pytest.mark.parametrize("name", CUT)
def test_it_cuts_the_prediction_error_on_the_wheel_axes(name: str) -> None:
    mission, windows = unseen_flight(name)
    believed = build_rate_model(mission.believed, friction=False)
    nominal = wheel_axis_rms(np.zeros_like(windows.residual), windows, believed)
    for network_name, cut_wanted in CUT[name].items():
        network = read_network(
            shipped(name, network_name), mission.model.spacecraft, mission.believed, False
        )
        estimates = self_fed(network, windows, believed)
        left = wheel_axis_rms(estimates, windows, believed)
        assert left < (1.0 - cut_wanted) * nominal
        flipped = wheel_axis_rms(-estimates, windows, believed)
        assert flipped > 1.8 * nominal  # a wrong sign would be seen


@pytest.mark.parametrize("name", CUT)
def test_its_report_belongs_to_the_model(name: str) -> None:
    report = json.loads((MODELS / name / "network" / "report.json").read_text())
    mission = prepare(FlightSettings(model=MODELS / name / f"{name}.xml"))
    assert report["fingerprint"] == mission.model.spacecraft.fingerprint
    assert report["unseen_flights"]["pinn"]["cut_of_wheel_axis_error_percent"] > 90.0


def test_an_estimate_costs_a_small_part_of_a_control_step() -> None:
    mission = prepare(FlightSettings(duration_s=20.0))
    network = read_network(
        shipped("two_wheel", "pinn"), mission.model.spacecraft, mission.believed, False
    )
    x = np.zeros(16)
    times = []
    for _ in range(200):
        started = time.perf_counter()
        network.estimate(x)
        times.append(time.perf_counter() - started)
    assert np.median(times) < 0.02 * 0.1  # s: 2 % of the 100 ms that a step may take
