"""How a campaign ends: exit codes, one sentence, nothing lost."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from simsat.campaign import command
from simsat.campaign.command import CampaignSettings, campaign
from simsat.campaign.lock import locked
from simsat.campaign.run import CampaignRun, RunResult, failed, fly_run
from simsat.control.ground.errors import OutputError
from simsat.settings import CommonSettings
from tests.campaign_cases import HERE


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "local_pool", lambda workers: HERE)
    monkeypatch.setattr("sys.argv", ["campaign"])


def asked(out: Path, **changes: Any) -> CampaignSettings:
    return CampaignSettings(
        controllers=("nmpc",),
        attitudes="3",
        common=CommonSettings(duration_s=1.0),
        recordings="none",
        out=out,
        **changes,
    )


def table_of(folder: Path) -> object:
    return pq.read_table(folder / "results.parquet").to_pylist()


def failing(*indices: int) -> Any:
    def fly(run: CampaignRun) -> RunResult:
        return failed(run, "no luck") if run.index in indices else fly_run(run)

    return fly


def test_some_failed_runs_are_said_and_all_of_them_exit_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "fly_run", failing(1))
    assert campaign(asked(tmp_path / "some")) == 0
    assert "1 of 3 runs failed and say why in rows/" in capsys.readouterr().out
    monkeypatch.setattr(command, "fly_run", failing(0, 1, 2))
    assert campaign(asked(tmp_path / "all")) == 1
    assert "3 of 3 runs failed and say why in rows/" in capsys.readouterr().out


def test_a_disk_that_fills_up_at_any_write_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = tmp_path / "whole"
    flushes = 0
    real = os.fsync

    def count(handle: int) -> None:
        nonlocal flushes
        flushes += 1
        real(handle)

    monkeypatch.setattr(os, "fsync", count)
    assert campaign(asked(whole)) == 0
    total, room = flushes, 0
    assert total > 30

    def full(handle: int) -> None:
        nonlocal flushes
        flushes += 1
        if flushes > room:
            raise OSError(28, "No space left on device")
        real(handle)

    monkeypatch.setattr(os, "fsync", full)
    # The first are campaign.json's and settings.json's, the last is a folder's, which may fail.
    for room in range(4, total - 1, 5):
        out, flushes = tmp_path / str(room), 0
        assert campaign(asked(out)) == 3
        said = capsys.readouterr().err
        assert "No space left on device" in said
        assert f"of 3 runs on disk; go on with\n  python -m simsat.campaign --out {out}" in said
        flushes = -1000
        assert campaign(replace(asked(out), resume=True)) == 0
        assert table_of(out) == table_of(whole)


def test_a_folder_in_use_is_refused_and_left_as_it_is(tmp_path: Path) -> None:
    out = tmp_path / "held"
    assert campaign(asked(out)) == 0
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*") if path.name != "lock"}
    with locked(out), pytest.raises(OutputError, match="is in use by process"):
        campaign(replace(asked(out), resume=True))
    assert {path: path.stat().st_mtime_ns for path in before} == before


@pytest.mark.parametrize(
    "content", ["", "{bad", "[]", "\x00\x01", '{"settings": 3, "flown_with": []}']
)
@pytest.mark.parametrize("name", ["campaign.json", "settings.json"])
def test_a_damaged_note_is_written_anew_for_rows_know_what_they_are(
    tmp_path: Path, name: str, content: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "noted"
    assert campaign(asked(out)) == 0
    rows = {p: p.stat().st_mtime_ns for p in (out / "rows").iterdir()}
    before, table = (out / name).read_text(), table_of(out)
    (out / name).write_text(content)
    assert campaign(replace(asked(out), resume=True)) == 0
    assert f"'{out / name}'" in capsys.readouterr().out
    assert (out / name).read_text().replace('"resume": true', '"resume": false') == before
    assert {p: p.stat().st_mtime_ns for p in rows} == rows
    assert table_of(out) == table


def test_a_damaged_note_lets_no_other_campaign_in(tmp_path: Path) -> None:
    out = tmp_path / "mine"
    assert campaign(asked(out)) == 0
    (out / "campaign.json").write_text("{")
    with pytest.raises(OutputError, match="holds a flight with other settings"):
        campaign(replace(asked(out), resume=True, common=CommonSettings(duration_s=2.0)))


def test_files_that_change_while_it_flies_end_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fly_edited(run: CampaignRun) -> RunResult:
        result = fly_run(run)
        if run.index == 1:
            result.record["flown_with"]["model"] = "edited"
        return result

    monkeypatch.setattr(command, "fly_run", fly_edited)
    with pytest.raises(OutputError, match=r"flew run 1 with something else .*the compiled model"):
        campaign(asked(tmp_path / "out"))
    assert len(list((tmp_path / "out" / "rows").glob("*.json"))) == 1
