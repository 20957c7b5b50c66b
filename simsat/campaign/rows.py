"""A campaign's rows on disk: one file per run, complete or not there at all.

`rows/NNNNN.json` is written last and by an atomic rename: whatever kills the campaign, a row that
exists is whole. `rows/NNNNN.parquet` beside it holds the run's trajectory.
"""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from simsat.campaign.run import RunResult
from simsat.control.ground.errors import OutputError
from simsat.results.folder import write_json

ROWS = "rows"
KEYS = ("run", "study", "controller", "attitude", "axis_x", "axis_y", "axis_z", "angle_deg")
TOLD_BY_KEYS = ("controller", "axis", "angle_deg")  # settings that the keys already hold


def write_row(folder: Path, index: int, result: RunResult) -> None:
    """Keep a run's result; the row counts as finished once its JSON is there."""
    rows = folder / ROWS
    rows.mkdir(exist_ok=True)
    if result.trajectory is not None:
        pq.write_table(result.trajectory, rows / f"{index:05d}.parquet")
    write_json(rows / f"{index:05d}.json", result.record)


def finished(folder: Path) -> frozenset[int]:
    """Indices of the runs whose rows are on disk."""
    return frozenset(int(path.stem) for path in (folder / ROWS).glob("*.json"))


def read_records(folder: Path) -> list[dict[str, Any]]:
    """All rows in the order of the campaign, whatever the order they were flown in."""
    return [_read(path) for path in sorted((folder / ROWS).glob("*.json"))]


def _read(path: Path) -> dict[str, Any]:
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise OutputError(f"can't read the row '{path}' ({error}); delete it and resume") from error


def flat_rows(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """A flat dictionary per run: keys, then metrics, then settings by their dotted names.

    Nested names are joined by dots (`limit_violations.torque`, `nominal.mismatch`), lists become
    their text. Nothing in it depends on the clock or on the machine's load.
    """
    rows = []
    for record in records:
        settings = {k: v for k, v in record["settings"].items() if k not in TOLD_BY_KEYS}
        keys = {name: record[name] for name in KEYS}
        rows.append(keys | dict(_flat(record["metrics"])) | dict(_flat(settings)))
    return rows


def timing_rows(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What each run took; kept apart because it never repeats."""
    return [
        {"run": record["run"], "controller": record["controller"], **dict(_flat(record["timing"]))}
        for record in records
    ]


def _flat(nested: dict[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    for name, value in nested.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            text = isinstance(value, list)
            yield prefix + name, " ".join(map(str, value)) if text else value


def as_table(rows: list[dict[str, Any]]) -> pa.Table:
    """Rows with all columns that any of them has; a figure that a row lacks is null."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return pa.table({name: _column([row.get(name) for row in rows]) for name in names})


def _column(values: list[Any]) -> pa.Array:
    """Numbers, texts or booleans; a column without a value counts as numbers."""
    if all(value is None for value in values):
        return pa.array(values, pa.float64())
    if any(isinstance(value, float) for value in values):
        return pa.array(values, pa.float64())
    return pa.array(values)


def read_trajectories(folder: Path, records: list[dict[str, Any]]) -> pa.Table:
    """All trajectories in one table with the columns run, controller and attitude in front."""
    tables = []
    for record in records:
        path = folder / ROWS / f"{record['run']:05d}.parquet"
        if path.exists():
            table = pq.read_table(path)
            for position, name in enumerate(("run", "controller", "attitude")):
                table = table.add_column(position, name, [[record[name]] * len(table)])
            tables.append(table)
    return pa.concat_tables(tables) if tables else pa.table({})
