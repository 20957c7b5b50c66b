"""A network for the appendages, inside the learned controller's prediction: sound ones and bad."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from simsat.control.ground.errors import ForeignNetworkError, NetworkError, SettingsError
from simsat.control.interface.layers import Pilot
from simsat.control.learned.planner import build_learned_planner
from simsat.control.learned.prediction.propagation import build_propagator
from simsat.control.learned.prediction.selection import PredictionModel
from simsat.control.learned.settings import LearnedSettings
from simsat.control.model.appendage import AppendageNetwork
from simsat.control.model.momentum import MomentumModel
from simsat.flight.loop import Flight, fly
from simsat.flight.mission import Mission, prepare
from simsat.networks.appendage import choose_appendage, shipped_appendage
from simsat.results.metrics import error_deg
from simsat.settings import FlightSettings
from tests.bench.bad_appendages import SPOILT
from tests.learned_cases import TARGET, TRUE_J, craft

PANELS = Path("flexible_panels")
PERIOD = 0.5


def mission() -> Mission:
    return prepare(
        FlightSettings(
            model=PANELS,
            controller="nmpc-learned",
            axis=(0.53, 0.48, 0.7),
            angle_deg=75.0,
            duration_s=32.0,
        )
    )


def shipped() -> AppendageNetwork:
    network = choose_appendage("auto", PANELS, mission().model.spacecraft, PERIOD)
    assert network is not None
    return network


def flown_with(network: AppendageNetwork | None) -> Flight:
    ready = mission()
    settings = ready.settings
    planner = build_learned_planner(
        ready.believed, settings.learned, settings.q_target, settings.nmpc, network
    )
    pilot = Pilot(planner)
    return fly(ready.build_plant(), pilot, ready.periods, ready.ticks_per_period, ready.sense)


def share_of_network(flight: Flight) -> float:
    used = [step.plan.signals["prediction_model"] == 2.0 for step in flight.steps]
    return float(np.mean(used))


def vibration(flight: Flight) -> float:
    """Of the pointing error after arrival, deg."""
    error = error_deg(flight, TARGET)[-120:]
    trend = np.polyval(np.polyfit(np.arange(120.0), error, 1), np.arange(120.0))
    return float(np.std(error - trend))


def test_a_sound_network_is_adopted_and_brings_the_panels_at_rest() -> None:
    with_it, without = flown_with(shipped()), flown_with(None)
    assert share_of_network(with_it) > 0.4
    assert error_deg(with_it, TARGET)[-1] < 0.15
    assert vibration(with_it) < 0.7 * vibration(without)


@pytest.mark.parametrize(
    "name", ["sign flipped", "twice too strong", "explosive", "inertia 20 % off"]
)
def test_a_wrong_network_costs_next_to_nothing(name: str) -> None:
    flight = flown_with(SPOILT[name](shipped()))
    assert error_deg(flight, TARGET)[-1] < 0.2
    assert np.all(np.isfinite(flight.held_commands()))


def test_a_network_that_says_no_number_is_never_flown() -> None:
    network = shipped()
    flight = flown_with(replace(network, W=np.full_like(network.W, np.nan)))
    assert share_of_network(flight) == 0.0
    assert error_deg(flight, TARGET)[-1] < 0.2


def test_a_plan_ends_where_the_appendages_take_the_body() -> None:
    """A network of pure memory: c stays, and turns the body at -J_hub^-1 c."""
    spacecraft, inputs = craft(), 12
    W = np.zeros((6, inputs))
    W[:3, :3] = W[3:, :3] = np.eye(3)
    network = replace(
        shipped(),
        input_scale=np.ones(inputs),
        output_scale=np.ones(6),
        W=W,
        **{name: 0.0 * getattr(shipped(), name) for name in ("V",)},
    )
    model = MomentumModel(spacecraft, TRUE_J, np.array([0.0, 0.0, 0.0]))
    c = np.array([2e-3, -1e-3, 1.5e-3])
    x0 = np.r_[TARGET, np.zeros(4), c, c, np.zeros(2)]
    end, slope, x = build_propagator(spacecraft, network).linearize(
        model, x0, np.zeros((6, 2)), np.full(6, PERIOD), TARGET
    )
    turn = -3.0 * model.J_hub_inverse @ c  # rad, in 3 s
    assert end[:3] == pytest.approx(turn, rel=1e-5)
    assert end[5:8] == pytest.approx(model.J_hub_inverse @ c)
    assert x.shape == (7, 16)
    assert slope.shape == (11, 12)


def test_only_an_edited_model_goes_without_its_network(tmp_path: Path) -> None:
    spacecraft = mission().model.spacecraft
    edited = replace(spacecraft, fingerprint="another")
    path = shipped_appendage(PANELS)
    assert choose_appendage("none", PANELS, spacecraft, PERIOD) is None
    assert choose_appendage("auto", PANELS, edited, PERIOD) is None
    assert choose_appendage("auto", Path("two_wheel"), spacecraft, PERIOD) is None
    with pytest.raises(ForeignNetworkError, match="was trained for the spacecraft"):
        choose_appendage(str(path), PANELS, edited, PERIOD)
    with pytest.raises(NetworkError, match=r"no network file at .*train_appendage"):
        choose_appendage(str(tmp_path / "gone"), PANELS, spacecraft, PERIOD)


def test_a_network_that_is_not_there_can_not_be_asked_for() -> None:
    with pytest.raises(SettingsError, match="prediction network needs a network"):
        build_learned_planner(craft(), LearnedSettings(prediction="network"), TARGET)


def test_the_prediction_can_be_fixed() -> None:
    ready = mission()
    settings = replace(ready.settings.learned, prediction="nominal")
    planner = build_learned_planner(ready.believed, settings, TARGET, ready.settings.nmpc)
    flight = fly(ready.build_plant(), Pilot(planner), 6, ready.ticks_per_period, ready.sense)
    ranks = list(PredictionModel)
    used = {ranks[int(step.plan.signals["prediction_model"])] for step in flight.steps[1:]}
    assert used == {PredictionModel.NOMINAL}
