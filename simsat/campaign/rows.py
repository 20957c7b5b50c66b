"""A campaign's rows on disk: one file per run, complete or not there at all.

`rows/NNNNN.json` is written last: a row that exists is whole. `rows/NNNNN.parquet` beside it holds
the run's trajectory. Checksums of both are in the JSON, so that damage is seen wherever it falls.
"""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from simsat.campaign.run import RunResult
from simsat.control.ground.errors import OutputError
from simsat.results.files import write_json, write_table

ROWS = "rows"
ROW_NAME = re.compile(r"\d{5,}\.json")
CHECKSUM = "sha256"
TRAJECTORY = "trajectory_sha256"
PARTS: dict[str, type | tuple[type, ...]] = {
    "run": int,
    "study": str,
    "point": dict,
    "controller": str,
    "attitude": int,
    "angle_deg": (int, float),
    "settings": dict,
    "metrics": dict,
    "timing": dict,
}


class DamagedRowError(OutputError):
    """A row that can't be read, or isn't what was written."""


def write_row(folder: Path, index: int, result: RunResult) -> None:
    """Keep a run's result; the row counts as finished once its JSON is there."""
    rows = folder / ROWS
    rows.mkdir(exist_ok=True)
    table = trajectory_path(folder, index)
    if result.trajectory is None:
        table.unlink(missing_ok=True)
        digest = None
    else:
        write_table(table, result.trajectory)
        digest = hashlib.sha256(table.read_bytes()).hexdigest()
    record = result.record | {TRAJECTORY: digest}
    write_json(row_path(folder, index), record | {CHECKSUM: _checksum(record)})


def row_path(folder: Path, index: int) -> Path:
    """Where a run's row is."""
    return folder / ROWS / f"{index:05d}.json"


def trajectory_path(folder: Path, index: int) -> Path:
    """Where a run's trajectory is."""
    return folder / ROWS / f"{index:05d}.parquet"


def finished(folder: Path) -> frozenset[int]:
    """Indices of the runs whose rows are on disk; other files there don't count."""
    return frozenset(int(path.stem) for path in _row_paths(folder))


def read_records(folder: Path) -> list[dict[str, Any]]:
    """All rows in the order of the campaign, whatever the order they were flown in.

    Raises `DamagedRowError` for the first that is damaged.
    """
    return [read_row(folder, int(path.stem)) for path in sorted(_row_paths(folder))]


def _row_paths(folder: Path) -> list[Path]:
    return [p for p in (folder / ROWS).glob("*.json") if ROW_NAME.fullmatch(p.name)]


def read_row(folder: Path, index: int) -> dict[str, Any]:
    """A row as it was written. Raises `DamagedRowError` that says what is wrong with it."""
    path = row_path(folder, index)
    try:
        record = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError) as error:
        raise _damaged(path, f"{error}") from error
    if not isinstance(record, dict) or CHECKSUM not in record:
        raise _damaged(path, "it holds something else")
    stated = record.pop(CHECKSUM)
    if stated != _checksum(record):
        raise _damaged(path, "its content does not match its checksum")
    wrong = [name for name, kind in PARTS.items() if not isinstance(record.get(name), kind)]
    if wrong:
        raise _damaged(path, f"no sound {', '.join(wrong)} in it")
    _check_trajectory(trajectory_path(folder, index), record.get(TRAJECTORY))
    return record


def _check_trajectory(path: Path, stated: str | None) -> None:
    if stated is None:
        return
    try:
        found = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise _damaged(path, f"{error.strerror}") from error
    if found != stated:
        raise _damaged(path, "its content does not match its checksum")


def _damaged(path: Path, why: str) -> DamagedRowError:
    return DamagedRowError(f"can't use the row '{path}' ({why}): --resume flies it again")


def _checksum(record: dict[str, Any]) -> str:
    text = json.dumps(record, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def read_trajectories(folder: Path, records: list[dict[str, Any]]) -> pa.Table:
    """All trajectories in one table with the columns run, controller and attitude in front."""
    tables = []
    for record in records:
        if record[TRAJECTORY] is not None:
            table = pq.read_table(trajectory_path(folder, record["run"]))
            for position, name in enumerate(("run", "controller", "attitude")):
                table = table.add_column(position, name, [[record[name]] * len(table)])
            tables.append(table)
    return pa.concat_tables(tables) if tables else pa.table({})
