import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import load_file

from simsat.campaign.attitudes import choose_attitudes
from simsat.campaign.lock import locked
from simsat.control.ground import attitude
from simsat.control.ground.errors import OutputError, SettingsError
from simsat.learning import train as train_command
from simsat.learning.correction.data import FleetSettings, fly_fleet, start_attitude
from simsat.learning.correction.fit import FitSettings, PinnState, RoundData, run_epoch
from simsat.learning.files import claim_folder, read_telemetry
from simsat.learning.resumable import train_resumably
from simsat.learning.train import TrainSettings, train
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS

MODEL = MODELS / "two_wheel" / "two_wheel.xml"
TINY = TrainSettings(
    model=MODEL,
    flights=(6, 6),
    duration_s=3.0,
    fit=FitSettings(epochs=3, teacher_epochs=1, batch=16, hidden=(8,)),
)


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("trained") / "out"
    claim_folder(out, TINY)
    train(TINY, out, workers=2)
    return out


def same_weights(a: Path, b: Path) -> bool:
    first, second = load_file(a), load_file(b)
    return all(np.array_equal(first[name], second[name]) for name in first)


def test_it_writes_networks_pictures_and_a_report(trained: Path) -> None:
    names = {path.name for path in trained.iterdir()}
    pictures = {"curves.png", "scores.png", "flight.png"}
    assert names >= pictures | {"pinn.safetensors", "linear.safetensors", "report.md"}
    report = json.loads((trained / "report.json").read_text())
    assert report["flights_training_held_out_unseen"] == [8, 2, 2]
    assert [row["round"] for row in report["curves"]] == [1, 1, 1, 2, 2, 2]
    assert set(report["unseen_flights"]) == {"nominal", "linear", "pinn", "oracle"}
    assert report["unseen_flights"]["oracle"]["cut_of_wheel_axis_error_percent"] == 100.0


def test_an_interrupted_training_ends_in_the_same_weights(
    trained: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "again"
    claim_folder(out, TINY)
    for rounds in ("flights_1", "flights_2"):
        shutil.copytree(trained / rounds, out / rounds)
    monkeypatch.setattr(train_command, "run_epoch", interrupted_after(4))
    with pytest.raises(KeyboardInterrupt):
        train(TINY, out, workers=1)
    assert not (out / "pinn.safetensors").exists()
    monkeypatch.undo()
    assert claim_folder(out, TINY)
    train(TINY, out, workers=1)
    for name in ("round_1", "pinn", "linear"):
        assert same_weights(out / f"{name}.safetensors", trained / f"{name}.safetensors")


def interrupted_after(epochs: int) -> Callable[..., None]:
    left = iter(range(epochs))

    def run(state: PinnState, data: RoundData, settings: FitSettings, seed: int) -> None:
        if next(left, None) is None:
            raise KeyboardInterrupt
        run_epoch(state, data, settings, seed)

    return run


def test_flights_that_are_there_are_not_flown_again(trained: Path) -> None:
    folder = trained / "flights_1"
    fleet = FleetSettings(MODEL, flights=6, duration_s=3.0)
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    (folder / "flight_0002.npz").rename(folder / "moved")
    flights = fly_fleet(folder, fleet, workers=1)
    assert len(flights) == 6
    again, moved = read_telemetry(folder / "flight_0002.npz"), read_telemetry(folder / "moved")
    assert np.array_equal(again.omega, moved.omega)  # flown alone by one worker: the same numbers
    (folder / "moved").replace(folder / "flight_0002.npz")
    after = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert after == before


def test_training_flights_start_away_from_the_campaigns() -> None:
    campaign = np.array(
        [attitude.from_axis_angle(np.array(c.axis), np.radians(c.angle_deg))
         for c in choose_attitudes("paper")]
    )  # fmt: skip
    starts = np.array([start_attitude(seed, i) for seed in (0, 1) for i in range(60)])
    nearest = [attitude.error_angle(q, campaign).min() for q in starts]
    assert min(nearest) > np.radians(5.0)
    apart = [attitude.error_angle(q, np.delete(starts, i, axis=0)).min()
             for i, q in enumerate(starts)]  # fmt: skip
    assert min(apart) > 0.0
    assert np.array_equal(start_attitude(1, 3), start_attitude(1, 3))


def test_a_folder_of_other_settings_is_refused(tmp_path: Path) -> None:
    assert not claim_folder(tmp_path / "new", TINY)
    other = TrainSettings(model=MODEL, seed=3)
    with pytest.raises(OutputError, match=r"other settings \(--duration-s, --fit, --fli"):
        claim_folder(tmp_path / "new", other)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").touch()
    with pytest.raises(OutputError, match="exists already and is not a training's; name another"):
        claim_folder(tmp_path / "full", TINY)
    with pytest.raises(OutputError, match=r"thesis.tex' is a file; name a folder"):
        claim_folder(tmp_path / "full" / "thesis.tex", TINY)
    (tmp_path / "full" / "settings.json").write_text("{bad")
    with pytest.raises(OutputError, match=r"can't read .*settings.json'"):
        claim_folder(tmp_path / "full", TINY)


def test_a_folder_left_by_a_kill_before_it_said_its_settings_is_claimed(tmp_path: Path) -> None:
    (tmp_path / "settings.json.part").write_text("{")
    assert not claim_folder(tmp_path, TINY)
    assert claim_folder(tmp_path, TINY)


def test_two_trainings_at_once_in_a_folder_are_refused(tmp_path: Path) -> None:
    claim_folder(tmp_path, TINY)
    with locked(tmp_path), pytest.raises(OutputError, match="is in use by process"):
        train_resumably(TINY, tmp_path, 1, train, "")
    assert not list(tmp_path.glob("flights_1"))


def test_a_folder_begun_with_other_packages_is_refused(tmp_path: Path) -> None:
    claim_folder(tmp_path / "new", TINY)
    note = tmp_path / "new" / "settings.json"
    told = json.loads(note.read_text())
    told["trained_with"]["packages"]["torch"] = "1.0"
    note.write_text(json.dumps(told))
    with pytest.raises(OutputError, match=r"was begun otherwise \(torch was 1.0, now 2"):
        claim_folder(tmp_path / "new", TINY)
    note.write_text("[]")
    with pytest.raises(OutputError, match=r"settings.json' holds something else"):
        claim_folder(tmp_path / "new", TINY)


def test_networks_say_what_they_were_trained_with(trained: Path) -> None:
    with safe_open(trained / "pinn.safetensors", framework="numpy") as file:
        told = json.loads(file.metadata()["trained_with"])
    assert told["packages"].keys() >= {"torch", "mujoco", "numpy"}
    assert told["model"] == read_model(MODEL).identity
    assert len(told["code"]["sha256"]) == 64


def test_damaged_files_say_what_to_delete(trained: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "damaged"
    shutil.copytree(trained, damaged)
    (damaged / "checkpoint.pt").write_bytes(b"half a checkpoint")
    with pytest.raises(OutputError, match=r"checkpoint.pt' can't be read .*: delete it"):
        train(TINY, damaged, workers=1)
    (damaged / "flights_1" / "flight_0001.npz").write_bytes(b"PK")
    with pytest.raises(OutputError, match=r"flight_0001.npz' is not the telemetry .*: delete it"):
        train(TINY, damaged, workers=1)


def test_too_few_flights_are_refused() -> None:
    with pytest.raises(SettingsError, match=r"at least 6 per round, got \(6, 2\)"):
        TrainSettings(flights=(6, 2))
    with pytest.raises(SettingsError, match="--flights is 0: give a whole number from 1 up"):
        FleetSettings(flights=0)
