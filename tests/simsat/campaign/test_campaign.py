"""A campaign gives the same table however it was flown: workers, kills and resumptions included."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from simsat.campaign import command as command_line
from simsat.campaign.attitudes import spiral_attitudes
from simsat.campaign.command import CampaignSettings, campaign, fly_missing, refuse_unflyable
from simsat.campaign.folder import identity, open_folder
from simsat.campaign.recordings import record_chosen, worst
from simsat.campaign.rows import finished, read_records, write_row
from simsat.campaign.run import CampaignRun, fly_run, plan_runs
from simsat.campaign.study import grid, parse_variation
from simsat.campaign.table import as_table, flat_rows
from simsat.comparison.results import write_campaign_results
from simsat.control.ground.errors import OutputError, SettingsError, SimsatError
from simsat.control.ground.settings import changed
from simsat.flight.mission import prepare
from simsat.results.flight_result import FlightResult
from simsat.settings import CommonSettings, FlightSettings
from tests.campaign_cases import HERE
from tests.places import MODELS

SHORT = FlightSettings(duration_s=2.0)
FLAGS = ["--controllers", "nmpc", "--duration-s", "2", "--recordings", "none"]


def runs_of(count: int, *vary: str, base: FlightSettings = SHORT) -> tuple[CampaignRun, ...]:
    points = grid(tuple(map(parse_variation, vary)))
    return plan_runs(base, ("nmpc",), spiral_attitudes(count), points)


def command(*flags: str) -> list[str]:
    return [sys.executable, "-m", "simsat.campaign", *FLAGS, *flags]


def table_of(folder: Path) -> object:
    return pq.read_table(folder / "results.parquet").to_pylist()


def test_runs_are_planned_point_by_point_and_controllers_meet_the_same_attitudes() -> None:
    points = grid((parse_variation("nominal.mismatch=0,2"),))
    runs = plan_runs(SHORT, ("nmpc", "other"), spiral_attitudes(3), points)
    assert [run.index for run in runs] == list(range(12))
    assert [run.settings.nominal.mismatch for run in runs] == [0.0] * 6 + [2.0] * 6
    assert [run.settings.controller for run in runs[:6]] == ["nmpc"] * 3 + ["other"] * 3
    for mine, theirs in zip(runs[:3], runs[3:6], strict=True):
        assert mine.attitude == theirs.attitude
        assert replace(mine.settings, controller="other") == theirs.settings


def test_sensor_noise_differs_between_attitudes_and_follows_the_seed() -> None:
    seeds = [run.settings.sensors.seed for run in runs_of(50)]
    assert len(set(seeds)) == 50
    other = replace(SHORT, sensors=replace(SHORT.sensors, seed=1))
    assert not set(seeds) & {run.settings.sensors.seed for run in runs_of(50, base=other)}


def test_a_row_holds_what_the_flight_alone_gives(tmp_path: Path) -> None:
    run = runs_of(2)[1]
    write_row(tmp_path, run.index, fly_run(run))
    (record,) = read_records(tmp_path)
    mission = prepare(run.settings)
    metrics = dict(FlightResult(mission, mission.fly()).metrics)
    assert record["timing"].keys() >= {"solve_time_ms", "wall_s", "cpu_s", "worker"}
    del metrics["solve_time_ms"]
    assert record["metrics"] == metrics
    (row,) = flat_rows([record])
    assert (row["run"], row["attitude"], row["angle_deg"]) == (1, 1, 125.0)
    assert row["limit_violations.torque"] == 0
    assert row["nmpc.horizon"] == 24
    trajectory = pq.read_table(tmp_path / "rows" / "00001.parquet")
    assert trajectory["t_s"].to_pylist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert trajectory["error_deg"][0].as_py() == pytest.approx(125.0, abs=1e-9)
    assert trajectory["error_deg"][-1].as_py() == metrics["final_error_deg"]


def test_killed_at_any_moment_and_resumed_with_other_workers_gives_the_same_table(
    tmp_path: Path,
) -> None:
    flags = ["--attitudes", "8"]
    whole = command(*flags, "--workers", "1", "--out", str(tmp_path / "a"))
    assert subprocess.run(whole).returncode == 0
    killed = subprocess.Popen(command(*flags, "--workers", "2", "--out", str(tmp_path / "b")))
    while not finished(tmp_path / "b"):
        assert killed.poll() is None
        time.sleep(0.005)
    killed.kill()
    killed.wait()
    before = {p: p.stat().st_mtime_ns for p in (tmp_path / "b" / "rows").glob("*.json")}
    assert 0 < len(before) < 8
    assert not (tmp_path / "b" / "results.parquet").exists()
    resumed = command(*flags, "--workers", "1", "--out", str(tmp_path / "b"), "--resume")
    assert subprocess.run(resumed).returncode == 0
    assert {p: p.stat().st_mtime_ns for p in before} == before  # none was flown again
    for name in ("results.parquet", "trajectories.parquet"):
        one, other = (pq.read_table(tmp_path / folder / name) for folder in "ab")
        assert one.equals(other), name
    for name in ("table.md", "table.csv", "comparison.md"):
        assert (tmp_path / "a" / name).read_text() == (tmp_path / "b" / name).read_text()


def test_a_study_has_the_results_of_every_point(tmp_path: Path) -> None:
    runs = runs_of(2, "orbit.altitude-km=400,500", base=replace(SHORT, duration_s=1.0))
    fly_missing(tmp_path, runs, HERE)
    (tmp_path / "settings.json").write_text("{}")
    text = write_campaign_results(tmp_path, read_records(tmp_path))
    assert text.startswith("| orbit.altitude_km | controller | runs |")
    assert {path.name for path in (tmp_path / "points").iterdir()} == {"00", "01"}
    for point, altitude in (("00", "400"), ("01", "500")):
        report = (tmp_path / "points" / point / "report.html").read_text()
        assert f"orbit.altitude_km={altitude}" in report
    assert (tmp_path / "study.png").exists()


def test_sigterm_stops_it_cleanly_and_says_how_to_go_on(tmp_path: Path) -> None:
    out = tmp_path / "c"
    process = subprocess.Popen(
        command("--attitudes", "200", "--workers", "1", "--out", str(out)),
        stderr=subprocess.PIPE,
        text=True,
    )
    while not finished(out):
        assert process.poll() is None
        time.sleep(0.005)
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 3
    done = len(finished(out))
    assert f"interrupted, with {done} of 200 runs on disk; go on with" in errors
    assert f"python -m simsat.campaign {' '.join(FLAGS)} --attitudes 200" in errors
    assert f"--out {out} --resume" in errors
    assert "Traceback" not in errors


def test_a_run_that_raises_is_a_row_with_its_reason(tmp_path: Path) -> None:
    good, bad = runs_of(2)
    bad = replace(bad, settings=replace(bad.settings, controller="autopilot"))
    fly_missing(tmp_path, (good, bad), HERE)
    first, second = read_records(tmp_path)
    assert first["metrics"]["ending"] == "complete"
    assert second["metrics"]["ending"] == "failed"
    assert "no controller 'autopilot'; there are: nmpc" in second["metrics"]["reason"]
    assert "SettingsError" in second["traceback"]
    (tmp_path / "settings.json").write_text("{}")
    write_campaign_results(tmp_path, [first, second])
    table = pq.read_table(tmp_path / "results.parquet")
    assert table["converged"].to_pylist() == [False, False]
    assert table["final_error_deg"].to_pylist()[1] is None
    assert table["nmpc.horizon"].to_pylist() == [24, 24]


def test_a_campaign_in_which_everything_failed_still_has_its_results(tmp_path: Path) -> None:
    runs = [replace(run, settings=replace(run.settings, controller="x")) for run in runs_of(2)]
    fly_missing(tmp_path, tuple(runs), HERE)
    (tmp_path / "settings.json").write_text("{}")
    text = write_campaign_results(tmp_path, read_records(tmp_path))
    assert "0 / 2" in text
    said = command_line.failures(read_records(tmp_path))
    assert said.startswith("2 of 2 runs failed and say why in rows/")
    assert (tmp_path / "report.html").exists()


def test_rows_are_whole_or_absent(tmp_path: Path) -> None:
    (run,) = runs_of(1)
    result = fly_run(run)
    write_row(tmp_path, 0, result)
    (tmp_path / "rows" / "00001.part").write_text('{"run": 1, "contr')  # killed while writing
    assert finished(tmp_path) == {0}
    assert len(read_records(tmp_path)) == 1


def test_columns_are_numbers_where_any_row_has_one() -> None:
    table = as_table([{"a": None, "b": 1, "c": None}, {"a": 0.5, "b": 2.5, "d": "x"}])
    assert table.to_pylist() == [
        {"a": None, "b": 1.0, "c": None, "d": None},
        {"a": 0.5, "b": 2.5, "c": None, "d": "x"},
    ]
    assert [str(field.type) for field in table.schema] == ["double", "double", "double", "string"]


def folder_of(settings: CampaignSettings, resume: bool) -> Path:
    starts = spiral_attitudes(int(settings.attitudes))
    runs = plan_runs(settings.common, settings.controllers, starts, grid(()))
    mine = identity(settings.common, settings.controllers, starts, runs)
    with open_folder(settings.out, resume, mine, settings) as folder:
        return folder


def test_resume_goes_on_with_the_same_campaign_only(tmp_path: Path) -> None:
    out = tmp_path / "d"
    settings = CampaignSettings(controllers=("nmpc",), attitudes="4", out=out)
    assert folder_of(settings, resume=True) == out  # never begun: begin it
    assert folder_of(replace(settings, workers=7), resume=True) == out
    with pytest.raises(OutputError, match="exists already"):
        folder_of(settings, resume=False)
    longer = replace(changed(settings, {"common.nmpc.horizon": 20}), controllers=("a", "b"))
    with pytest.raises(OutputError) as refused:
        folder_of(longer, resume=True)
    assert 'controllers was ["nmpc"], now ["a", "b"]' in str(refused.value)
    assert "nmpc.horizon was 24, now 20" in str(refused.value)
    with pytest.raises(OutputError, match="attitudes: 4 then, 6 now"):
        folder_of(replace(settings, attitudes="6"), resume=True)


def copied_model(folder: Path) -> Path:
    """two_wheel with its includes, in a place of its own."""
    for name in ("two_wheel", "parts"):
        shutil.copytree(MODELS / name, folder / name)
    return folder / "two_wheel" / "two_wheel.xml"


def test_resume_refuses_an_edit_of_an_included_file(tmp_path: Path) -> None:
    common = CommonSettings(model=copied_model(tmp_path))
    settings = CampaignSettings(
        attitudes="1", out=tmp_path / "e", common=common, controllers=("nmpc",)
    )
    folder_of(settings, resume=False)
    wheels = tmp_path / "parts" / "wheels.xml"
    text = wheels.read_text()
    wheels.write_text(f"<!-- a remark -->{text}")
    folder_of(settings, resume=True)  # MuJoCo flies the same
    wheels.write_text(re.sub(r'actrange="\S+ \S+"', 'actrange="-.04 .04"', text))
    assert wheels.read_text() != text
    with pytest.raises(OutputError, match=r"the compiled model \(its file, an included file or"):
        folder_of(settings, resume=True)


def test_resume_refuses_rows_of_another_engine_or_code(tmp_path: Path) -> None:
    settings = CampaignSettings(attitudes="1", out=tmp_path / "h")
    record = folder_of(settings, resume=False) / "campaign.json"
    told = json.loads(record.read_text())
    for flown_with in told["flown_with"]:
        flown_with["packages"]["mujoco"] = "4.9"
        flown_with["code"] |= {"revision": "before", "sha256": "0123456789abcdef"}
    record.write_text(json.dumps(told))
    with pytest.raises(OutputError) as refused:
        folder_of(settings, resume=True)
    assert "mujoco was 4.9, now 4." in str(refused.value)
    assert "simsat's own code was before (01234567), now " in str(refused.value)


def test_resume_refuses_what_is_no_campaign(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"is no campaign's folder: it has no campaign.json"):
        folder_of(CampaignSettings(attitudes="1", out=tmp_path), resume=True)
    begun = tmp_path / "begun"  # killed before campaign.json was written
    begun.mkdir()
    (begun / "settings.json").write_text("{}")
    settings = CampaignSettings(attitudes="1", out=begun)
    assert folder_of(settings, resume=True) == begun
    assert (begun / "campaign.json").exists()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"controllers": ("nmpc", "nmpc")}, "--controllers needs one or more names, each once"),
        ({"controllers": ()}, "--controllers needs one or more names"),
        ({"workers": 0}, "--workers is 0: give a whole number from 1"),
        ({"resume": True}, "--resume needs --out, the folder to go on with"),
        ({"workers": 2, "cluster": "tcp://x:1"}, "--workers and --cluster exclude each other"),
    ],
)
def test_bad_settings_are_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        CampaignSettings(**changes)  # type: ignore[arg-type]


def test_bad_points_are_refused_before_anything_flies(tmp_path: Path) -> None:
    out = tmp_path / "f"
    settings = CampaignSettings(
        attitudes="2", out=out, controllers=("nmpc",), vary=("model=two_wheel,nine_wheel",)
    )
    with pytest.raises(SimsatError, match="nine_wheel"):
        campaign(settings)
    assert not out.exists()
    with pytest.raises(SettingsError, match="no controller 'autopilot'"):
        refuse_unflyable(plan_runs(SHORT, ("nmpc", "autopilot"), spiral_attitudes(1), ({},)))


def test_worst_runs_are_those_that_did_not_converge_then_the_largest_errors() -> None:
    def record(
        run: int, controller: str, converged: bool, error: float | None
    ) -> dict[str, object]:
        metrics = {"converged": converged, "final_error_deg": error}
        return {"run": run, "controller": controller, "metrics": metrics}

    records = [
        record(0, "a", True, 0.4),
        record(1, "a", False, 0.1),
        record(2, "a", False, None),
        record(3, "a", True, 0.2),
        record(4, "b", True, 0.3),
    ]
    assert [r["run"] for r in worst(records, 3)] == [2, 1, 0, 4]
    assert [r["run"] for r in worst(records)] == [2, 1, 0, 3, 4]


def test_recordings_repeat_their_rows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = runs_of(2)
    fly_missing(tmp_path, runs, HERE)
    records = read_records(tmp_path)
    record_chosen(tmp_path, runs, records, "none", HERE)
    assert not (tmp_path / "recordings").exists()
    records[1]["metrics"]["final_error_deg"] += 1e-12
    record_chosen(tmp_path, runs, records, "worst", HERE)
    said = capsys.readouterr().out
    assert "00001-nmpc-attitude-001 did not repeat" in said
    assert "00000" not in said
    folders = sorted((tmp_path / "recordings").iterdir())
    assert [folder.name for folder in folders] == [run.name for run in runs]
    for folder in folders:
        files = {path.name for path in folder.iterdir()}
        assert files == {
            "model", "metrics.json", "recording.rrd", "settings.json", "steps.parquet",
            "summary.png",
            "timeseries.parquet",
        }  # fmt: skip
    whole = folders[0] / "recording.rrd"
    before = whole.stat().st_mtime_ns
    (folders[1] / "metrics.json").write_text("{")
    record_chosen(tmp_path, runs, records, "worst", HERE)  # the damaged one, once more
    assert json.loads((folders[1] / "metrics.json").read_text())["ending"] == "complete"
    assert whole.stat().st_mtime_ns == before


def test_resume_command_repeats_the_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["campaign", "--attitudes", "my file.csv"])
    assert command_line.resume_command(Path("runs/x")) == (
        "python -m simsat.campaign --attitudes 'my file.csv' --out runs/x --resume"
    )
    monkeypatch.setattr(sys, "argv", ["campaign", "--out=runs/x", "--resume"])
    assert command_line.resume_command(Path("runs/x")) == (
        "python -m simsat.campaign --out=runs/x --resume"
    )


def test_help_explains_every_flag_and_hides_what_the_campaign_chooses() -> None:
    environment = os.environ | {"COLUMNS": "200"}
    said = subprocess.run(
        [sys.executable, "-m", "simsat.campaign", "--help"],
        capture_output=True,
        text=True,
        env=environment,
    ).stdout
    for flag in ("controllers", "attitudes", "vary", "study", "workers", "cluster", "recordings"):
        assert f"--{flag}" in said
    assert "--nominal.mismatch" in said
    assert "--angle-deg" not in said


def test_campaign_json_says_what_was_flown(tmp_path: Path) -> None:
    settings = CampaignSettings(attitudes="2", out=tmp_path / "g")
    folder_of(settings, resume=False)
    told = json.loads((tmp_path / "g" / "campaign.json").read_text())
    assert [start["angle_deg"] for start in told["attitudes"]] == [75.0, 125.0]
    assert told["flight"]["nmpc"]["horizon"] == 24
    assert "controller" not in told["flight"]
    assert json.loads((tmp_path / "g" / "settings.json").read_text())["versions"]["mujoco"]
