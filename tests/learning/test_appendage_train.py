"""The training command, on flights made up beforehand."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load_file

from simsat.control.ground.errors import OutputError, SettingsError
from simsat.learning import train_appendage as train_command
from simsat.learning.appendage.fit import (
    AppendageFitSettings,
    AppendageState,
    TrainingProblem,
    run_epoch,
)
from simsat.learning.correction import data
from simsat.learning.correction.data import (
    FleetSettings,
    fly_fleet,
    fly_one,
    start_attitude,
    starting_at,
)
from simsat.learning.files import claim_folder, read_telemetry, write_telemetry
from simsat.learning.train_appendage import AppendageSettings, begun, train
from simsat.mjcf import Model
from simsat.mjcf.shipped import MODELS
from simsat.networks.appendage import read_appendage
from simsat.settings import FlightSettings
from tests.appendage_cases import PERIOD, made_up_flights

MODEL = MODELS / "two_wheel" / "two_wheel.xml"
TINY = AppendageSettings(
    model=MODEL,
    flights=(6, 6),
    duration_s=10.0,
    fit=AppendageFitSettings(width=2, gates=1, horizon=4, epochs=6, iterations=20),
)


def with_flights(out: Path, model: Model) -> Path:
    """A claimed folder in which all flights are flown already."""
    claim_folder(out, TINY)
    for number in (1, 2):
        folder = out / f"flights_{number}"
        folder.mkdir()
        flights, _ = made_up_flights(model.spacecraft, 6, 20, seed=number)
        for i, flight in enumerate(flights):
            write_telemetry(folder / f"flight_{i:04d}.npz", flight)
    return out


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory, two_wheel: Model) -> Path:
    out = with_flights(tmp_path_factory.mktemp("trained") / "out", two_wheel)
    train(TINY, out, workers=2)
    return out


def same_weights(a: Path, b: Path) -> bool:
    first, second = load_file(a), load_file(b)
    return first.keys() == second.keys() and all(
        np.array_equal(first[name], second[name]) for name in first
    )


def test_it_writes_networks_and_a_report(trained: Path, two_wheel: Model) -> None:
    report = json.loads((trained / "report.json").read_text())
    assert report["flights_training_held_out_unseen"] == [8, 2, 2]
    assert [row["round"] for row in report["curves"]] == 6 * [1] + 6 * [2] + 6 * [3]
    errors = report["rate_error_rms_rad_s"]
    assert list(errors) == ["no network", "c held", "least squares", "linear", "gate", "tanh"]
    assert max(errors["linear"]) < 0.1 * min(errors["no network"])
    network = read_appendage(trained / "appendage.safetensors", two_wheel.spacecraft, PERIOD)
    assert network.width == report["width"]
    assert np.array_equal(network.J, report["J_kg_m2"])
    text = (trained / "report.md").read_text()
    assert "| no network | " in text
    assert "The tanh layer takes the held-out loss from " in text
    assert (trained / "scores.png").is_file()


def test_a_tanh_layer_that_does_not_help_is_left_out(trained: Path) -> None:
    """The made-up craft is exactly linear, its motors have no ramp."""
    report = json.loads((trained / "report.json").read_text())
    assert report["width"] == 0
    assert same_weights(trained / "appendage.safetensors", trained / "linear.safetensors")


def test_least_squares_in_the_report_is_untouched_by_training(trained: Path) -> None:
    losses = json.loads((trained / "report.json").read_text())["loss_held_out"]
    assert losses["linear"] < 0.9 * losses["least squares"]


@pytest.mark.parametrize("epochs", [2, 8, 14])
def test_an_interrupted_training_ends_in_the_same_weights(
    trained: Path, tmp_path: Path, two_wheel: Model, monkeypatch: pytest.MonkeyPatch, epochs: int
) -> None:
    out = with_flights(tmp_path / "again", two_wheel)
    monkeypatch.setattr(train_command, "run_epoch", interrupted_after(epochs))
    with pytest.raises(KeyboardInterrupt):
        train(TINY, out, workers=1)
    assert not (out / "appendage.safetensors").exists()
    monkeypatch.undo()
    assert claim_folder(out, TINY)
    train(TINY, out, workers=1)
    assert same_weights(out / "appendage.safetensors", trained / "appendage.safetensors")
    assert (out / "report.json").read_bytes() == (trained / "report.json").read_bytes()


def interrupted_after(epochs: int) -> Callable[..., None]:
    left = iter(range(epochs))

    def run(
        state: AppendageState, problem: TrainingProblem, settings: AppendageFitSettings
    ) -> None:
        if next(left, None) is None:
            raise KeyboardInterrupt
        run_epoch(state, problem, settings)

    return run


def test_a_damaged_checkpoint_says_what_to_delete(trained: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "damaged"
    shutil.copytree(trained, damaged)
    (damaged / "checkpoint_gate.pt").write_bytes(b"half a checkpoint")
    with pytest.raises(OutputError, match=r"checkpoint_gate.pt' can't be read .*: delete it"):
        train(TINY, damaged, workers=1)


def test_flights_under_the_learned_controller_do_not_depend_on_the_workers(tmp_path: Path) -> None:
    fleet = FleetSettings(MODEL, flights=2, duration_s=2.0)
    flown = fly_fleet(tmp_path / "pool", fleet, 2, "nmpc-learned")
    base = FlightSettings(model=MODEL, controller="nmpc-learned", duration_s=2.0)
    fly_one(tmp_path / "alone.npz", starting_at(base, start_attitude(0, 1)))
    alone = read_telemetry(tmp_path / "alone.npz")
    assert np.array_equal(flown[1].omega, alone.omega)
    assert np.abs(alone.torque).max() == 0.05  # Nm: it is the learned controller's bang-bang


def test_settings_out_of_range_are_refused() -> None:
    with pytest.raises(SettingsError, match=r"at least 6 per round, got \(6, 2\)"):
        AppendageSettings(flights=(6, 2))
    with pytest.raises(SettingsError, match=r"--duration-s is 5: give 16 control periods, 8 s,"):
        begun(AppendageSettings(duration_s=5.0))


def test_training_flights_do_not_depend_on_the_network_that_ships(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    panels = MODELS / "flexible_panels" / "flexible_panels.xml"
    asked: list[FlightSettings] = []
    monkeypatch.setattr(
        data,
        "_fly_all",
        lambda jobs, workers: asked.extend(job[1] for job in jobs),
    )
    with pytest.raises(OutputError, match="is not the telemetry of a training flight"):
        fly_fleet(tmp_path, FleetSettings(panels, flights=1, duration_s=2.0), 1, "nmpc-learned")
    assert [settings.learned.network for settings in asked] == ["none"]
