"""References from CSV files: attitudes over time, or targets with dwell times."""

import csv
from pathlib import Path

import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.control.reference.reference import Reference, Sequence
from simsat.reference.samples import UNIT, curve_through

QUATERNION = ["q_w", "q_x", "q_y", "q_z"]
OVER_TIME = ["t_s", *QUATERNION]
DWELLS = ["dwell_s", *QUATERNION]
ROWS_MAX = 2_000_000


def read_table(path: Path, duration: float) -> Reference:
    """The reference of a CSV file whose first row names its columns: `t_s` and the quaternion
    (scalar first, body -> inertial) for attitudes over time, or `dwell_s` and the quaternion for
    targets, each of which counts for so long, the slew to it included.

    Raises `SettingsError` in one sentence on anything else.
    """
    name = f"--reference '{path}'"
    header, rows = _read(path, name)
    if header == OVER_TIME:
        return curve_through(name, rows[:, 0], rows[:, 1:], duration)
    return _targets(name, rows[:, 0], rows[:, 1:], duration)


def _targets(name: str, dwell: Array, q: Array, duration: float) -> Sequence:
    size = np.linalg.norm(q, axis=1)
    if not np.all(np.abs(size - 1.0) <= UNIT):
        raise SettingsError(f"{name}: every target must be a unit quaternion q_w q_x q_y q_z")
    if not np.all((dwell > 0.0) & np.isfinite(dwell)):
        raise SettingsError(f"{name}: every dwell_s must be a finite number above zero")
    if dwell.sum() < duration * (1.0 - 1e-9):
        raise SettingsError(
            f"{name}: its dwells end after {dwell.sum():g} s, the flight lasts {duration:g} s"
        )
    starts = np.concatenate([[0.0], np.cumsum(dwell)[:-1]])
    return Sequence(starts, attitude.normalized(q))


def _read(path: Path, name: str) -> tuple[list[str], Array]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = csv.reader(file)
            header = [cell.strip() for cell in next(lines, [])]
            if header not in (OVER_TIME, DWELLS):
                raise SettingsError(
                    f"{name}: its first row must be {','.join(OVER_TIME)} or {','.join(DWELLS)}, "
                    f"it is {','.join(header) or 'empty'}"
                )
            rows = []
            for row in lines:
                if row:
                    rows.append(_numbers(name, lines.line_num, row))
                if len(rows) > ROWS_MAX:
                    raise SettingsError(f"{name} has more than {ROWS_MAX:,} rows")
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SettingsError(f"{name} can't be read: {error}") from error
    if not rows:
        raise SettingsError(f"{name} has no rows")
    return header, np.array(rows)


def _numbers(name: str, line: int, row: list[str]) -> list[float]:
    try:
        numbers = [float(cell) for cell in row]
    except ValueError:
        numbers = []
    if len(numbers) != len(OVER_TIME):
        raise SettingsError(f"{name}, line {line}: {len(OVER_TIME)} numbers are wanted")
    return numbers
