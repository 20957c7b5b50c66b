"""The appendage networks that come with the models: still those of the models, and still good."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch

from simsat.flight.mission import prepare
from simsat.learning.appendage.report import AHEAD, score
from simsat.learning.appendage.rollout import as_module
from simsat.learning.appendage.series import build_series
from simsat.learning.correction.data import start_attitude, starting_at
from simsat.learning.correction.windows import Telemetry
from simsat.mjcf.shipped import MODELS
from simsat.networks.appendage import read_appendage
from simsat.settings import FlightSettings
from tests.appendage_cases import PERIOD

torch.set_num_threads(1)

LEFT = {"flexible_panels": 0.1}
"""Part of the rate error without a network that may be left, 1 to 16 periods ahead."""
ALONG_LEFT = {"flexible_panels": 0.3}
"""The same of c along the unactuated axis; of the panels' without the gate about all is left."""


@pytest.mark.parametrize("name", LEFT)
def test_it_cuts_the_rate_error_on_a_fresh_flight(name: str) -> None:
    """Under the controller it is made for, from a start no training used: their seeds are small."""
    base = FlightSettings(model=MODELS / name / f"{name}.xml", controller="nmpc-learned")
    mission = prepare(starting_at(base, start_attitude(1_000_000, 0)))
    flight = mission.fly()
    plant, craft = flight.plant, mission.model.spacecraft
    network = read_appendage(MODELS / name / "network" / "appendage.safetensors", craft, PERIOD)
    telemetry = Telemetry(plant.tick, plant.rates, plant.wheel_speeds, np.array(flight.commands))
    module = as_module(network, craft, mission.believed.J)
    series = build_series([telemetry], craft, mission.believed.J, PERIOD, swing=5e-3)
    scores = score({"network": module}, series)
    for k in AHEAD:
        assert scores["network"].rate[k - 1] < LEFT[name] * scores["no network"].rate[k - 1]
        assert scores["network"].along[k - 1] < ALONG_LEFT[name] * scores["no network"].along[k - 1]
    with torch.no_grad():
        module.W *= -1.0
        module.V *= -1.0
        module.B *= -1.0
    flipped = score({"network": module}, series)["network"]
    assert flipped.rate[0] > scores["no network"].rate[0]  # a wrong sign would be seen


@pytest.mark.parametrize("name", LEFT)
def test_its_report_belongs_to_the_model(name: str) -> None:
    folder: Path = MODELS / name / "network"
    report = json.loads((folder / "report.json").read_text())
    craft = prepare(FlightSettings(model=MODELS / name / f"{name}.xml")).model.spacecraft
    network = read_appendage(folder / "appendage.safetensors", craft, PERIOD)
    assert report["fingerprint"] == craft.fingerprint
    assert report["J_kg_m2"] == network.J.tolist()
    # The rows of J that motion shows, against the file's: kg m^2.
    assert np.abs(network.J - craft.J)[:2, :2].max() < 0.002 * craft.J[0, 0]


def test_the_default_command_is_what_ships() -> None:
    """The gate is in both, the tanh layer in the panels' network and not in the propellant's."""
    reports = {
        name: json.loads((MODELS / name / "network" / "report.json").read_text()) for name in LEFT
    }
    sizes = {name: (report["gates"], report["width"]) for name, report in reports.items()}
    assert sizes == {"flexible_panels": (4, 16)}
