"""A campaign's folder after accidents: damaged rows fly again, foreign ones are refused by name."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from simsat.campaign.attitudes import spiral_attitudes
from simsat.campaign.command import fly_missing
from simsat.campaign.healing import survey
from simsat.campaign.rows import read_records, read_row, write_row
from simsat.campaign.run import CampaignRun, RunResult, failed, fly_run, plan_runs
from simsat.campaign.table import as_table, flat_rows
from simsat.control.ground.errors import OutputError
from simsat.settings import FlightSettings
from tests.campaign_cases import HERE

SHORT = FlightSettings(duration_s=1.0)


def planned(base: FlightSettings = SHORT) -> tuple[CampaignRun, ...]:
    return plan_runs(base, ("nmpc",), spiral_attitudes(4), ({},))


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    fly_missing(folder, planned(), HERE)
    return folder


@pytest.fixture
def folder(flown: Path, tmp_path: Path) -> Path:
    shutil.copytree(flown / "rows", tmp_path / "rows")
    return tmp_path


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def empty(path: Path) -> None:
    path.write_bytes(b"")


def fill_with_noise(path: Path) -> None:
    path.write_bytes(bytes((37 * i) % 256 for i in range(3000)))


def flip_a_bit(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 1
    path.write_bytes(content)


def edit_a_figure(path: Path) -> None:
    record = json.loads(path.read_text())
    record["metrics"]["final_error_deg"] *= 0.5
    path.write_text(json.dumps(record))


def nest_too_deep(path: Path) -> None:
    path.write_text("[" * 100_000)


def replace_by(text: str) -> Callable[[Path], None]:
    def damage(path: Path) -> None:
        path.write_text(text)

    return damage


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("00002.json", truncate),
        ("00002.json", empty),
        ("00002.json", fill_with_noise),
        ("00002.json", flip_a_bit),
        ("00002.json", edit_a_figure),
        ("00002.json", nest_too_deep),
        ("00002.json", replace_by("[1, 2]")),
        ("00002.json", replace_by("{}")),
        ("00002.json", replace_by('{"run": 2, "sha256": "0"}')),
        ("00002.json", replace_by("null")),
        ("00002.parquet", truncate),
        ("00002.parquet", empty),
        ("00002.parquet", fill_with_noise),
        ("00002.parquet", flip_a_bit),
        ("00002.parquet", Path.unlink),
        ("00002.json", Path.unlink),
    ],
)
def test_a_damaged_row_counts_as_not_flown_and_is_flown_again(
    flown: Path,
    folder: Path,
    name: str,
    damage: Callable[[Path], None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    damage(folder / "rows" / name)
    found = survey(folder, planned())
    assert found.done == {0, 1, 3}
    untouched = {p: p.stat().st_mtime_ns for p in (folder / "rows").glob("0000[013]*")}
    fly_missing(folder, planned(), HERE)
    said = capsys.readouterr().out
    if damage is not Path.unlink or name.endswith("parquet"):
        assert f"can't use the row '{folder / 'rows' / name}'" in said
        assert "flies it again" in said
    assert {p: p.stat().st_mtime_ns for p in untouched} == untouched
    whole, healed = (as_table(flat_rows(read_records(where))) for where in (flown, folder))
    assert whole.equals(healed)
    for kept in ("00002.parquet", "00000.parquet"):
        assert (folder / "rows" / kept).read_bytes() == (flown / "rows" / kept).read_bytes()


def test_a_row_put_in_another_s_place_is_refused_by_name(folder: Path) -> None:
    shutil.copy(folder / "rows" / "00001.json", folder / "rows" / "00003.json")
    shutil.copy(folder / "rows" / "00001.parquet", folder / "rows" / "00003.parquet")
    with pytest.raises(OutputError) as refused:
        fly_missing(folder, planned(), HERE)
    assert str(refused.value) == (
        f"'{folder / 'rows' / '00003.json'}' holds run 1 (nmpc, attitude 1, 125 deg), expected "
        "run 3 (nmpc, attitude 3, 125 deg): move the file away and --resume"
    )


def test_a_row_of_another_campaign_is_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"00000.json' holds a flight with other settings"):
        survey(folder, planned(FlightSettings(duration_s=2.0)))
    with pytest.raises(OutputError, match=r"00003.json' holds run 3 .*, expected no such run"):
        survey(folder, planned()[:3])
    (run, *_) = planned()
    record = read_row(folder, 0)
    record["flown_with"]["packages"]["casadi"] = "3.1"
    write_row(folder, run.index, RunResult(record, None))
    with pytest.raises(OutputError, match=r"made with something else, expected casadi was 3\.1"):
        survey(folder, planned())


def test_what_is_no_row_is_left_alone_and_named(folder: Path) -> None:
    rows = folder / "rows"
    for name in ("00003 (copy).json", "00001.json~", ".00001.json.swp", "notes.txt", "1.json"):
        shutil.copy(rows / "00001.json", rows / name)
    leftovers = [rows / name for name in ("00002.json.part", "00007.parquet.part")]
    for part in leftovers:
        part.write_text("{")
    found = survey(folder, planned())
    assert found.done == {0, 1, 2, 3}
    (remark,) = found.remarks
    assert remark.endswith(": .00001.json.swp, 00001.json~, 00003 (copy).json, 1.json, notes.txt")
    assert not any(part.exists() for part in leftovers)
    assert len(read_records(folder)) == 4


def test_a_failed_row_takes_the_place_of_a_damaged_one_with_its_trajectory(folder: Path) -> None:
    truncate(folder / "rows" / "00002.json")
    write_row(folder, 2, failed(planned()[2], "no luck"))
    assert not (folder / "rows" / "00002.parquet").exists()
    assert survey(folder, planned()).done == {0, 1, 2, 3}


@pytest.mark.parametrize("fails_at", [1, 2])
def test_a_row_on_a_full_disk_is_the_old_one_or_none(
    folder: Path, monkeypatch: pytest.MonkeyPatch, fails_at: int
) -> None:
    """The flush of the trajectory fails, or that of the row itself."""
    flushed = 0
    real = os.fsync

    def full(handle: int) -> None:
        nonlocal flushed
        flushed += os.path.isfile(f"/proc/self/fd/{handle}")
        if flushed >= fails_at:
            raise OSError(28, "No space left on device")
        real(handle)

    result = fly_run(planned()[2])
    (folder / "rows" / "00002.json").unlink()
    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(OSError, match="No space left"):
            write_row(folder, 2, result)
    assert not list((folder / "rows").glob("*.part"))
    assert survey(folder, planned()).done == {0, 1, 3}
    write_row(folder, 2, result)
    assert survey(folder, planned()).done == {0, 1, 2, 3}
