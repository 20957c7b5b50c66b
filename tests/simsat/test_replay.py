"""A profile replayed from its file: a run's outputs, true to the reference, bad input refused."""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from simsat.control.ground.errors import OutputError, SettingsError
from simsat.flight.loop import Ending
from simsat.mjcf.shipped import MODELS
from simsat.replay import ReplaySettings, prepare_replay, replay
from simsat.run import OutputSettings
from tests.reference_cases import NO_TORQUE, angle_deg, load_case

TWO_WHEEL = MODELS / "two_wheel" / "two_wheel.xml"


def profile(folder: Path, **entries: Any) -> Path:
    path = folder / "profile.npz"
    arrays: dict[str, Any] = {"u": np.full((4, 2), 0.01), "dt_u": 0.5} | entries
    np.savez(path, **arrays)
    return path


def test_replay_leaves_a_run_s_folder_that_agrees_with_the_reference(tmp_path: Path) -> None:
    case = load_case("c_gg_2rw")
    model = tmp_path / "case.xml"
    model.write_text(case.xml)
    settings = ReplaySettings(
        profile=case.path, model=model, output=OutputSettings(tmp_path / "out"),
        orbit=case.orbit, environment=case.environment,
    )  # fmt: skip
    assert replay(settings) == 0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {
        "model", "recording.rrd", "metrics.json", "settings.json", "timeseries.parquet",
        "steps.parquet",
        "summary.png",
    }  # fmt: skip
    table = pq.read_table(tmp_path / "out" / "timeseries.parquet").to_pydict()
    rows = np.rint(case.data["t"] / 0.05).astype(int)
    q = np.stack([table[f"q_{part}"] for part in "wxyz"], axis=1)[rows]
    assert angle_deg(q, case.data["q"]).max() < 1e-6  # degrees
    H = np.stack([table[f"momentum_N_{part}"] for part in "xyz"], axis=1)[rows]
    assert np.abs(H - case.data["H_N"]).max() < 1e-9  # Nms
    commanded = np.array(table["torque_command_wheel_0"])[rows[:-1]]
    np.testing.assert_array_equal(commanded, case.data["u"][:, 0])
    saved = json.loads((tmp_path / "out" / "settings.json").read_text())["settings"]
    assert saved["orbit"]["altitude_km"] == 450.0
    assert saved["profile"].endswith("c_gg_2rw.npz")


def test_command_line_plays_a_profile_on_the_default_spacecraft(tmp_path: Path) -> None:
    arguments = [profile(tmp_path), "--out", tmp_path / "out", "--no-recording"]
    done = subprocess.run(
        [sys.executable, "-m", "simsat.replay", *map(str, arguments), "--environment.no-drag"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "flown to the end" in done.stdout
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text())
    assert metrics["flown_s"] == pytest.approx(2.0)
    refused = subprocess.run(
        [sys.executable, "-m", "simsat.replay", "nowhere.npz"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert refused.returncode == 2
    assert refused.stderr.strip() == "error: no profile at 'nowhere.npz'"


def test_the_model_s_limits_hold_for_a_profile_too(tmp_path: Path) -> None:
    path = profile(tmp_path, u=np.full((4, 2), 0.09))
    mission = prepare_replay(ReplaySettings(path, environment=NO_TORQUE))
    flight = mission.fly()
    assert flight.ending is Ending.COMPLETE
    assert flight.plant.torques.max() == pytest.approx(0.05)  # Nm, the motors' limit
    assert np.diff(flight.plant.torques, axis=0).max() <= 0.4 * 0.05 * (1 + 1e-9)  # Nm/s * s
    assert flight.held_commands().max() == 0.09


def test_without_a_start_the_profile_begins_at_rest(tmp_path: Path) -> None:
    mission = prepare_replay(ReplaySettings(profile(tmp_path)))
    np.testing.assert_array_equal(mission.profile.q, [1.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(mission.profile.omega, np.zeros(3))
    np.testing.assert_array_equal(mission.profile.wheel_speed, np.zeros(2))


@pytest.mark.parametrize(
    ("torque", "reason"),
    [
        (1e8, "the rates of free, wheel_0"),
        (1e300, r"the commanded torque .*1\.e.300 .*Nm is not finite or no wheel"),
    ],
)
def test_a_profile_that_diverges_ends_early_with_its_reason(
    tmp_path: Path, torque: float, reason: str
) -> None:
    case = load_case("a_diag_2rw")
    model = tmp_path / "case.xml"
    model.write_text(case.xml)
    path = profile(tmp_path, u=np.array([[0.01, 0.0], [torque, 0.0], [torque, torque]]))
    mission = prepare_replay(ReplaySettings(path, model, environment=NO_TORQUE))
    flight = mission.fly()
    assert flight.ending is Ending.DIVERGED
    assert re.search(reason, flight.reason)
    assert np.isfinite(flight.plant.rates).all()


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({"u": np.zeros((4, 3))}, r"u has the shape \(4, 3\), but 'two_wheel' has 2 wheels"),
        ({"u": np.zeros(4)}, r"must be \(rows, 2\)"),
        ({"u": np.zeros((0, 2))}, r"must be \(rows, 2\)"),
        ({"u": np.full((4, 2), np.nan)}, "u holds a number that isn't finite"),
        ({"u": np.array([["a", "b"]])}, "u holds no numbers"),
        ({"dt_u": 0.0}, "dt_u must be one number of seconds above zero"),
        ({"dt_u": [0.5, 0.5]}, "dt_u must be one number"),
        ({"dt_u": 0.135}, "0.135 s is not a whole number of 0.01 s"),
        ({"q0": np.zeros(4)}, "q0 is zero"),
        ({"q0": np.full(4, 1e200)}, "q0 is zero or huge"),
        ({"w0": np.full(3, 1e300)}, "w0 is beyond 3600 deg/s"),
        ({"u": np.zeros((4, 2), complex)}, "u holds no numbers"),
        ({"dt_u": 1e9}, r"4e\+09 s in samples of --sample-s 0\.05 s make 8e\+10 samples"),
        ({"q0": np.ones(3)}, r"q0 has the shape \(3,\), it must be \(4,\)"),
        ({"Om0": np.ones(3)}, r"Om0 has the shape \(3,\), it must be \(2,\)"),
    ],
)
def test_a_bad_profile_is_refused(tmp_path: Path, entries: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        prepare_replay(ReplaySettings(profile(tmp_path, **entries)))


def test_a_file_that_is_no_profile_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="is no NumPy archive"):
        prepare_replay(ReplaySettings(TWO_WHEEL))
    np.save(tmp_path / "plain.npy", np.zeros((4, 2)))
    with pytest.raises(SettingsError, match="is no NumPy archive"):
        prepare_replay(ReplaySettings(tmp_path / "plain.npy"))
    np.savez(tmp_path / "other.npz", torque=np.zeros((4, 2)))
    with pytest.raises(SettingsError, match="has no u and no dt_u, only torque; it needs u"):
        prepare_replay(ReplaySettings(tmp_path / "other.npz"))


def test_an_existing_folder_is_never_written_into(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="exists already"):
        replay(ReplaySettings(profile(tmp_path), output=OutputSettings(tmp_path)))
