"""A campaign's rows as tables: nested figures and settings laid flat, a column for each."""

from collections.abc import Iterable
from typing import Any

import pyarrow as pa

KEYS = ("run", "study", "controller", "attitude", "axis_x", "axis_y", "axis_z", "angle_deg")
TOLD_BY_KEYS = ("controller", "axis", "angle_deg")  # settings that the keys already hold


def flat_rows(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """A flat dictionary per run: keys, then metrics, then settings by their dotted names.

    Nested names are joined by dots (`limit_violations.torque`, `nominal.mismatch`), lists become
    their text. Nothing in it depends on the clock or on the machine's load.
    """
    rows = []
    for record in records:
        settings = {k: v for k, v in record["settings"].items() if k not in TOLD_BY_KEYS}
        keys = {name: record[name] for name in KEYS}
        rows.append(keys | dict(flat(record["metrics"])) | dict(flat(settings)))
    return rows


def timing_rows(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What each run took; kept apart because it never repeats."""
    return [
        {"run": record["run"], "controller": record["controller"], **dict(flat(record["timing"]))}
        for record in records
    ]


def flat(nested: dict[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    """Names joined by dots, lists as their text."""
    for name, value in nested.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
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
