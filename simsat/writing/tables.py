"""Tables of figures from TOML and CSV files."""

import csv
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from simsat.campaign.inputs import read_given
from simsat.control.ground.errors import ModelError

VECTORS = ("axis", "position", "inertia", "torque_envelope_rpm")


def read_toml(path: Path) -> dict[str, Any]:
    """What a TOML file says. Raises `ModelError` or `SettingsError` if it can't be read."""
    try:
        return tomllib.loads(read_given(path, "figures"))
    except ValueError as error:  # no TOML, or a number of too many digits
        raise ModelError(f"it is no TOML: {error}") from error
    except RecursionError:
        raise ModelError("it is nested too deeply") from None


def read_rows(given: Any, kind: str, folder: Path) -> list[Any]:
    """The tables of a list, from the TOML file itself or from the CSV file that it names.

    Raises `ModelError` if it is neither, or no such file can be read.
    """
    if isinstance(given, str):
        return list(_csv(folder / given, kind))
    if isinstance(given, list):
        return given
    raise ModelError(f"'{kind}' must be tables [[{kind}]] or the name of a CSV file")


def _csv(path: Path, kind: str) -> Iterator[dict[str, Any]]:
    """Rows of a CSV file whose columns are the tables' keys, a vector's numbers with spaces between
    (`position` = "0.1 0 -0.2"); empty cells are left out."""
    try:
        for row in csv.DictReader(
            read_given(path, kind).splitlines(), strict=True, skipinitialspace=True
        ):
            if None in row or None in row.values():
                raise ModelError(f"a line of '{path}' has other columns than its first")
            cells = {key.strip(): cell.strip() for key, cell in row.items()}
            yield {key: _cell(key, cell) for key, cell in cells.items() if cell}
    except csv.Error as error:
        raise ModelError(f"'{path}' is no CSV: {error}") from error


def _cell(key: str, cell: str) -> Any:
    if key == "name":
        return cell
    try:
        numbers = [float(word) for word in cell.split()]
    except ValueError:
        return cell
    return numbers if key in VECTORS else _one(numbers, cell)


def _one(numbers: list[float], cell: str) -> Any:
    return numbers[0] if len(numbers) == 1 else cell
