"""Results flown again: the same to the last bit, or the largest difference of each figure."""

import dataclasses
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from simsat import verify as module
from simsat.campaign.attitudes import spiral_attitudes
from simsat.campaign.command import fly_missing
from simsat.campaign.rows import read_row, write_row
from simsat.campaign.run import RunResult, failed, plan_runs
from simsat.control.ground.errors import OutputError, SettingsError
from simsat.replay import ReplaySettings, replay
from simsat.results.comparing import compared
from simsat.results.files import write_json
from simsat.results.saved import settings_from_json
from simsat.run import OutputSettings, RunSettings, run
from simsat.sensors.settings import SensorSettings
from simsat.settings import FlightSettings, NominalSettings, as_json
from simsat.verify import VerifySettings, verify
from tests.campaign_cases import HERE
from tests.places import ROOT


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("verify") / "run"
    sensors = SensorSettings(enabled=True, seed=3)
    assert (
        run(
            RunSettings(
                output=OutputSettings(out, False),
                flight=FlightSettings(duration_s=2.0, sensors=sensors),
            )
        )
        == 0
    )
    return out


@pytest.fixture
def folder(flown: Path, tmp_path: Path) -> Path:
    return shutil.copytree(flown, tmp_path / "run")


@pytest.fixture
def campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(module, "local_pool", lambda workers: HERE)
    runs = plan_runs(FlightSettings(duration_s=1.0), ("nmpc",), spiral_attitudes(4), ({},))
    fly_missing(tmp_path, runs, HERE)
    write_row(tmp_path, 3, failed(runs[3], "no luck"))
    write_json(tmp_path / "campaign.json", {})
    return tmp_path


def rewrite(path: Path, **changes: Any) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_a_run_repeats_itself_even_with_noise(flown: Path) -> None:
    verification = verify(flown)
    assert verification.same
    assert verification.changed == ()
    assert str(verification) == "1 flown again: the same to the last bit"


def test_the_last_bit_of_a_metric_counts_and_so_does_the_series(folder: Path) -> None:
    metrics = json.loads((folder / "metrics.json").read_text())
    rewrite(
        folder / "metrics.json",
        final_error_deg=float(np.nextafter(metrics["final_error_deg"], 0.0)),
        ending="diverged",
    )
    series = pq.read_table(folder / "timeseries.parquet")
    q = series["q_w"].to_numpy().copy()
    q[7] += 0.25
    place = series.column_names.index("q_w")
    pq.write_table(series.set_column(place, "q_w", pa.array(q)), folder / "timeseries.parquet")
    verification = verify(folder)
    named = {difference.name for difference in verification.differences}
    assert named == {"final_error_deg", "ending", "series.q_w"}
    said = str(verification)
    assert said.startswith("1 of 1 flown again came out otherwise, at most by\n")
    assert "  series.q_w: 0.25 apart in run" in said
    assert "  ending: diverged kept, complete flown in run" in said


def test_what_has_changed_since_is_said_and_is_no_difference_by_itself(folder: Path) -> None:
    saved = json.loads((folder / "settings.json").read_text())
    saved["flown_with"]["packages"]["scipy"] = "1.0"
    rewrite(folder / "settings.json", **saved)
    verification = verify(folder)
    assert verification.same
    assert str(verification).startswith("not as it was: scipy was 1.0, now ")


def test_a_replay_is_verified_too(tmp_path: Path) -> None:
    profile = tmp_path / "profile.npz"
    np.savez(profile, u=np.full((4, 2), 0.01), dt_u=0.5)
    assert replay(ReplaySettings(profile, output=OutputSettings(tmp_path / "out", False))) == 0
    assert verify(tmp_path / "out").same
    np.savez(profile, u=np.full((4, 2), 0.011), dt_u=0.5)
    verification = verify(tmp_path / "out")
    assert not verification.same
    assert verification.changed == ("the content of the profile",)


@pytest.mark.parametrize(("rows", "flown"), [(None, 3), (2, 2), (50, 3)])
def test_a_campaign_s_flown_rows_repeat(campaign: Path, rows: int | None, flown: int) -> None:
    verification = verify(campaign, rows)
    assert verification.same
    assert verification.flown == flown  # the fourth failed


def test_the_largest_difference_of_each_figure_is_named_with_its_run(campaign: Path) -> None:
    for index, off in ((0, 1e-9), (2, 1e-3)):
        record = read_row(campaign, index)
        record["metrics"]["final_error_deg"] += off
        table = pq.read_table(campaign / "rows" / f"{index:05d}.parquet")
        write_row(campaign, index, RunResult(record, table))
    verification = verify(campaign)
    assert [d.name for d in verification.differences] == ["final_error_deg"] * 2
    said = str(verification)
    assert said.startswith("2 of 3 flown again came out otherwise")
    assert "final_error_deg: 0.001 apart in 00002-nmpc-attitude-002" in said
    assert "00000" not in said


def test_folders_without_results_are_refused(
    tmp_path: Path, folder: Path, campaign: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(OutputError, match="is no folder of a run or a campaign"):
        verify(tmp_path / "none")
    (campaign / "rows" / "00001.json").write_text("{")
    with pytest.raises(OutputError, match=r"can't use the row .*00001.json"):
        verify(campaign)
    for index in (0, 1, 2):
        (campaign / "rows" / f"{index:05d}.json").unlink()
    with pytest.raises(OutputError, match=r"no run in .* was flown"):
        verify(campaign)
    rewrite(folder / "metrics.json", ending="interrupted")
    with pytest.raises(OutputError, match="was interrupted: there is no whole one to repeat"):
        verify(folder)
    (folder / "metrics.json").write_text("[]")
    with pytest.raises(OutputError, match=r"metrics.json' holds no object but list"):
        verify(folder)
    (folder / "metrics.json").unlink()
    with pytest.raises(OutputError, match=r"can't read .*metrics.json"):
        verify(folder)
    with pytest.raises(SettingsError, match="--rows is 0: give a whole number from 1 up"):
        VerifySettings(tmp_path, rows=0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sensors": None}, "holds no FlightSettings of this version"),
        ({"angle_deg": "wide"}, "of this version: --angle-deg is 'wide'"),
        ({"duration_s": -1.0}, "--duration-s is -1: give a finite number above 0"),
    ],
)
def test_damaged_settings_are_refused(folder: Path, change: Any, message: str) -> None:
    saved = json.loads((folder / "settings.json").read_text())
    rewrite(folder / "settings.json", settings=saved["settings"] | change)
    with pytest.raises((OutputError, SettingsError), match=message):
        verify(folder)
    del saved["settings"]["model"]
    rewrite(folder / "settings.json", **saved)
    with pytest.raises(OutputError, match=r"settings.json' holds no .*: no model"):
        verify(folder)


def test_settings_come_back_as_they_went() -> None:
    settings = FlightSettings(
        nominal=NominalSettings(inertia_factors=(1.0, 0.9, 1.1)),
        start=dataclasses.replace(FlightSettings().start, wheel_speed_rpm=(10.0, 0.1)),
    )
    for one in (FlightSettings(), settings):
        there = json.loads(json.dumps(as_json(one)))
        assert settings_from_json(FlightSettings, there, Path("x")) == one


def test_figures_are_compared_by_name_kind_and_value() -> None:
    kept = {"a": 1, "b": {"c": 1.0, "d": None}, "e": np.array([1.0, np.nan])}
    assert compared("run", kept, {**kept, "e": np.array([1.0, np.nan])}) == []
    flown = {"a": 1.0, "b": {"c": 1.5}, "e": np.array([1.0]), "f": "new"}
    assert [str(difference) for difference in compared("run", kept, flown)] == [
        "a: 0 apart in run",
        "b.c: 0.5 apart in run",
        "e: 2 values kept, 1 values flown in run",
        "f: nothing kept, new flown in run",
    ]


def test_the_command_s_exit_code(flown: Path, folder: Path) -> None:
    def answer(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "simsat.verify", *arguments],
            cwd=ROOT, capture_output=True, text=True, check=False,
        )  # fmt: skip

    assert answer(str(flown)).returncode == 0
    rewrite(folder / "metrics.json", control_steps=5)
    other = answer(str(folder))
    assert (other.returncode, other.stderr) == (1, "")
    assert "control_steps: 1 apart in run" in other.stdout
    bad = answer(str(folder / "none"))
    assert bad.returncode == 2
    assert len(bad.stderr.splitlines()) == 1
