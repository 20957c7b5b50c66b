"""python -m simsat.run, as a user meets it."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from simsat.flight.mission import prepare
from simsat.results.flight_result import FlightResult
from simsat.settings import FlightSettings
from tests.places import ROOT


def run(*arguments: str, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "simsat.run", *arguments],
        cwd=cwd, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run") / "out"
    answer = run("--duration-s", "3", "--angle-deg", "75", "--out", str(out))
    assert answer.returncode == 0, answer.stderr
    for words in ("unactuated direction", "true", "nominal", "final error", "rerun "):
        assert words in answer.stdout
    return out


def test_a_run_leaves_the_five_files(flown: Path) -> None:
    names = {path.name for path in flown.iterdir()}
    assert names == {
        "model", "recording.rrd", "metrics.json", "settings.json", "timeseries.parquet",
        "steps.parquet",
        "summary.png",
    }  # fmt: skip


def test_the_time_series_has_the_promised_columns_at_20_hz(flown: Path) -> None:
    table = pq.read_table(flown / "timeseries.parquet")
    wheels = [
        f"{what}_{wheel}"
        for what in ("wheel_speed", "torque_command", "torque_limited", "torque_applied")
        for wheel in ("wheel_x", "wheel_y")
    ]
    assert table.column_names == [
        "t_s", "q_w", "q_x", "q_y", "q_z", "omega_x", "omega_y", "omega_z", "error_deg",
        "q_ref_w", "q_ref_x", "q_ref_y", "q_ref_z",
        "momentum_N_x", "momentum_N_y", "momentum_N_z", *wheels,
    ]  # fmt: skip
    t = table["t_s"].to_numpy()
    np.testing.assert_allclose(t, 0.05 * np.arange(61), atol=1e-12)
    assert table["error_deg"][0].as_py() == pytest.approx(75.0)
    limit = np.abs(table["torque_applied_wheel_x"].to_numpy()).max()
    assert 0.01 < limit <= 0.05 + 1e-12


def test_settings_and_metrics_can_be_read_back(flown: Path) -> None:
    settings = json.loads((flown / "settings.json").read_text())
    assert settings["settings"]["angle_deg"] == 75.0
    assert settings["settings"]["environment"]["drag"] is True
    assert settings["settings"]["nmpc"]["period"] is None  # as it was given
    assert settings["came_to"]["nmpc.period"] == 0.5  # s
    assert settings["came_to"]["correction.limit_Nm"] == 0.015
    flown_with = settings["flown_with"]
    assert len(flown_with["model"]) == 64
    assert flown_with["networks"].keys() == {"network"}
    assert flown_with["packages"]["mujoco"].startswith("4.")
    assert settings["versions"]["rerun-sdk"].startswith("0.")
    metrics = json.loads((flown / "metrics.json").read_text())
    for name in (
        "converged", "settling_time_s", "steady_state_rmse_deg", "final_error_deg",
        "peak_wheel_speed_rpm", "peak_torque_Nm", "limit_violations", "solver_failures",
        "solve_time_ms", "ending", "reason",
    ):  # fmt: skip
        assert name in metrics
    assert metrics["control_steps"] == 6


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--model", "absent.xml"], "no model file at 'absent.xml'"),
        (["--controller", "pid"], "no controller 'pid'; there are: nmpc"),
        (["--angle-deg", "nan"], "--angle-deg is nan: give a finite number"),
        (["--angle-deg", "0"], "--angle-deg is 0: give a finite number other than zero"),
        (["--axis", "0", "0", "0"], "--axis must be three finite numbers, not all zero"),
        (["--axis", "inf", "0", "0"], "--axis is inf 0 0: give 3 values, each a finite number"),
        (["--target", "0", "0", "0", "0"], "--target must be a quaternion"),
        (["--duration-s", "0.7", "--nmpc.period", "0.5"], "0.7 s is not a whole number of 0.5 s"),
        (["--sample-s", "0.075"], "0.075 s is not a whole number of 0.01 s"),
        (["--out", str(ROOT)], "exists already; name a new folder"),
        (["--out", "/proc/none/run"], "can't write the folder '/proc/none/run'"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_2(arguments: list[str], sentence: str) -> None:
    answer = run(*arguments)
    assert answer.returncode == 2
    assert sentence in answer.stderr
    assert len(answer.stderr.strip().splitlines()) == 1


def test_a_folder_s_name_that_is_too_long_is_bad_input() -> None:
    answer = run("--out", "a" * 300)
    assert answer.returncode == 2
    assert "error: can't write the folder" in answer.stderr
    assert "Traceback" not in answer.stderr


def test_output_that_nobody_reads_is_one_sentence_and_exit_3() -> None:
    reader, writer = os.pipe()
    os.close(reader)  # what `| head` does
    answer = subprocess.run(
        [sys.executable, "-m", "simsat.run", "--help"],
        cwd=ROOT, stdout=writer, stderr=subprocess.PIPE, text=True, check=False, timeout=120,
    )  # fmt: skip
    os.close(writer)
    assert answer.returncode == 3
    assert answer.stderr == "error: broken off: [Errno 32] Broken pipe\n"


def test_a_foreign_control_package_is_no_trouble(tmp_path: Path) -> None:
    """python-control's package comes first on the path of this folder; ours is simsat.control."""
    (tmp_path / "control").mkdir()
    (tmp_path / "control" / "__init__.py").write_text("")
    answer = run("--help", cwd=tmp_path)
    assert (answer.returncode, answer.stderr) == (0, "")


def test_our_folder_is_not_taken_for_python_control() -> None:
    script = "import control"
    answer = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert "this is simsat's folder 'control'" in answer.stderr


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_interrupted_writes_everything_and_says_why(
    tmp_path: Path, stop: signal.Signals
) -> None:
    out = tmp_path / "out"
    process = start(out)
    wait_for(out / "recording.rrd", 300_000)
    process.send_signal(stop)
    assert process.wait(60) == 3
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["ending"] == "interrupted"
    assert metrics["flown_s"] < 20000
    assert pq.read_table(out / "timeseries.parquet").num_rows > 10
    assert (out / "summary.png").stat().st_size > 10_000
    assert verified(out / "recording.rrd")


def test_a_run_that_is_killed_leaves_a_readable_recording(tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start(out)
    wait_for(out / "recording.rrd", 300_000)
    process.kill()
    process.wait(60)
    answer = rerun("print", str(out / "recording.rrd"))
    assert answer.returncode == 0
    assert "/signals/error" in answer.stdout


def start(out: Path) -> subprocess.Popen[bytes]:
    """A long flight, to be stopped."""
    return subprocess.Popen(
        [sys.executable, "-m", "simsat.run", "--duration-s", "20000", "--out", str(out)],
        cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def wait_for(path: Path, size: int) -> None:
    for _ in range(600):
        if path.exists() and path.stat().st_size > size:
            return
        time.sleep(0.1)
    raise AssertionError(f"{path} never reached {size} bytes")


def rerun(*arguments: str) -> subprocess.CompletedProcess[str]:
    tool = Path(sys.executable).with_name("rerun")
    environment = os.environ | {"RERUN": "off"}
    return subprocess.run(
        [str(tool), "rrd", *arguments], capture_output=True, text=True, check=False, env=environment
    )


def verified(recording: Path) -> bool:
    return rerun("verify", str(recording)).returncode == 0


def test_on_a_full_disk_the_recording_gives_way_to_the_results(tmp_path: Path) -> None:
    """No file may grow beyond 600 kB: the recording does, the results don't."""
    out = tmp_path / "out"
    script = (
        "import resource, runpy, sys\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, 600_000))\n"
        "sys.argv[1:] = ['--duration-s', '150', '--out', sys.argv[1]]\n"
        "runpy.run_module('simsat.run', run_name='__main__', alter_sys=True)\n"
    )
    answer = subprocess.run(
        [sys.executable, "-c", script, str(out)],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert answer.returncode == 3
    assert f"error: the disk is full: '{out}' has no recording.rrd" in answer.stderr
    assert "Traceback" not in answer.stderr
    names = {path.name for path in out.iterdir()}
    assert names == {
        "model", "metrics.json", "settings.json", "summary.png", "steps.parquet",
        "timeseries.parquet",
    }  # fmt: skip
    assert pq.read_table(out / "timeseries.parquet").num_rows == 3001
    assert json.loads((out / "metrics.json").read_text())["ending"] == "complete"


def test_results_that_find_the_disk_full_take_the_recording_s_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission = prepare(FlightSettings(duration_s=1.0))
    flight = mission.fly()
    (tmp_path / "recording.rrd").write_bytes(b"large")
    real = os.fsync

    def full(handle: int) -> None:
        if (tmp_path / "recording.rrd").exists():
            raise OSError(errno.ENOSPC, "No space left on device")
        real(handle)

    monkeypatch.setattr(os, "fsync", full)
    FlightResult(mission, flight).write(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        "metrics.json", "summary.png", "steps.parquet", "timeseries.parquet",
    }  # fmt: skip
    monkeypatch.setattr(os, "fsync", lambda handle: os.stat("/nowhere"))
    with pytest.raises(FileNotFoundError):  # another failure takes nothing
        FlightResult(mission, flight).write(tmp_path)
