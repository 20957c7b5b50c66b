"""The initial attitudes of a campaign: the paper's hundred, a count, or a user's own file."""

import csv
import io
import math
import os.path
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simsat.campaign.inputs import read_given
from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.settings import has_direction

PAPER = "paper"
PAPER_COUNT = 100
ATTITUDES_MAX = 100_000  # half a day of flights of one controller on two cores
ANGLES_DEG = (75.0, 125.0)  # the paper turns about every direction by both
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))  # rad
COLUMNS = ("axis_x", "axis_y", "axis_z", "angle_deg")
EXCESS = "excess"  # where a row's values beyond the named columns end up


@dataclass(frozen=True)
class InitialRotation:
    """Where a run starts: the target turned by an angle about an axis."""

    index: int
    """Place in the campaign; controllers are compared index by index."""
    axis: tuple[float, float, float]
    angle_deg: float


def choose_attitudes(spec: str) -> tuple[InitialRotation, ...]:
    """The attitudes that `--attitudes` names: "paper", a count, or a file.

    Raises `SettingsError` that says what was given and what is allowed.
    """
    if spec == PAPER:
        return spiral_attitudes(PAPER_COUNT)
    if os.path.isfile(spec):
        return read_attitudes(Path(spec))
    try:
        count = int(spec)
    except ValueError:
        raise SettingsError(
            f"--attitudes takes '{PAPER}', a count or a file, and '{spec}' is no file here"
        ) from None
    if not 1 <= count <= ATTITUDES_MAX:
        raise SettingsError(f"--attitudes needs a count from 1 to {ATTITUDES_MAX}, got {spec}")
    return spiral_attitudes(count)


def spiral_attitudes(count: int) -> tuple[InitialRotation, ...]:
    """Both angles about each of count/2 Fibonacci directions, direction by direction.

    A count of 100 is the paper's campaign; an odd count leaves out the last large angle.
    """
    directions = fibonacci_directions((count + 1) // 2)
    return tuple(
        InitialRotation(i, (float(x), float(y), float(z)), ANGLES_DEG[i % 2])
        for i, (x, y, z) in enumerate(np.repeat(directions, 2, axis=0)[:count])
    )


def fibonacci_directions(n: int) -> Array:
    """n unit vectors spread evenly over the sphere, shape (n, 3).

    z_i = 1 - (2 i + 1)/n, longitude_i = i pi (3 - sqrt 5). Source: the paper's "Fibonacci
    sphere"; Gonzalez, Math. Geosci. 42 (2010) 49.
    """
    i = np.arange(n)
    z = 1.0 - (2.0 * i + 1.0) / n
    radius = np.sqrt(1.0 - z * z)
    longitude = GOLDEN_ANGLE * i
    return np.column_stack([radius * np.cos(longitude), radius * np.sin(longitude), z])


def read_attitudes(path: Path) -> tuple[InitialRotation, ...]:
    """The attitudes of a CSV file with the columns axis_x, axis_y, axis_z, angle_deg.

    The axis may have any length but zero. Raises `SettingsError` naming file and line.
    """
    text = read_given(path, "file of attitudes")
    reader = csv.DictReader(io.StringIO(text, newline=""), restkey=EXCESS)
    try:
        return _read_rows(reader, path)
    except csv.Error as error:  # a field without an end
        raise SettingsError(f"{path}, line {reader.line_num}: {error}") from error


def _read_rows(reader: csv.DictReader, path: Path) -> tuple[InitialRotation, ...]:
    missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        raise SettingsError(
            f"{path}: no column {', '.join(missing)}; the first line must name the columns "
            f"{', '.join(COLUMNS)}"
        )
    rows = [_read_row(row, f"{path}, line {reader.line_num}") for row in reader]
    if len(rows) > ATTITUDES_MAX:
        raise SettingsError(f"{path}: {len(rows)} attitudes, more than {ATTITUDES_MAX}")
    if not rows:
        raise SettingsError(f"{path}: no attitude below the line of column names")
    return tuple(InitialRotation(i, (x, y, z), a) for i, (x, y, z, a) in enumerate(rows))


def _read_row(row: dict[str, Any], where: str) -> list[float]:
    if EXCESS in row:
        raise SettingsError(f"{where}: more values than the first line names columns")
    try:
        numbers = [float(row[name] or "") for name in COLUMNS]
    except ValueError as error:
        raise SettingsError(f"{where}: four numbers wanted, {error}") from None
    if not has_direction(numbers[:3]) or not math.isfinite(numbers[3]) or numbers[3] == 0.0:
        text = " ".join(f"{number:g}" for number in numbers)
        raise SettingsError(f"{where}: axis and angle must be finite and not zero, got {text}")
    return numbers
