"""What is in a campaign's rows/ when it is resumed: which rows count, and what becomes of the rest.

A damaged row counts as not flown. A sound row of something else is refused by name: it was put
there by mistake, and to overwrite it would lose it. Files that are no rows are left alone.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simsat.campaign.rows import (
    ROWS,
    DamagedRowError,
    finished,
    read_row,
    row_path,
)
from simsat.campaign.run import CampaignRun, run_keys
from simsat.control.ground.errors import OutputError
from simsat.identity.difference import differences

OURS = re.compile(r"\d{5,}\.(json|parquet)(\.part)?")
PLACES = ("model", "network")  # settings that say where a file lies: its content is compared


@dataclass(frozen=True)
class Survey:
    """What rows/ holds."""

    done: frozenset[int]
    """Runs with a sound row of their own."""
    remarks: tuple[str, ...]
    """A sentence on everything else that was found."""


def survey(folder: Path, runs: tuple[CampaignRun, ...]) -> Survey:
    """Look at every file in rows/, and remove what a kill left half written.

    Raises `OutputError` that names a row of another run, attitude, setting or code.
    """
    done, remarks = set[int](), list[str]()
    for index in sorted(finished(folder)):
        try:
            record = read_row(folder, index)
        except DamagedRowError as error:
            remarks.append(str(error))
            continue
        _refuse_foreign(row_path(folder, index), record, index, runs)
        done.add(index)
    return Survey(frozenset(done), (*remarks, *_strays(folder)))


def _strays(folder: Path) -> list[str]:
    strays = []
    for path in sorted((folder / ROWS).glob("*")):
        if not OURS.fullmatch(path.name):
            strays.append(path.name)
        elif path.suffix == ".part":
            path.unlink()
    return [f"no rows, left alone in '{folder / ROWS}': {', '.join(strays)}"] if strays else []


def _refuse_foreign(
    path: Path, record: dict[str, Any], index: int, runs: tuple[CampaignRun, ...]
) -> None:
    if index >= len(runs):
        raise _foreign(path, _named(record), f"no such run among {len(runs)}")
    wanted = run_keys(runs[index])
    if any(record.get(key) != wanted[key] for key in wanted if key != "settings"):
        raise _foreign(path, _named(record), _named(wanted))
    if _placeless(record["settings"]) != _placeless(wanted["settings"]):
        raise _foreign(path, "a flight with other settings", _named(wanted))
    if record.get("flown_with") is not None:
        differing = differences(record["flown_with"], runs[index].flown_with)
        if differing:
            raise _foreign(path, "a flight made with something else", "; ".join(differing))


def _named(record: dict[str, Any]) -> str:
    study = f", {record['study']}" if record.get("study") else ""
    return (
        f"run {record['run']} ({record['controller']}, attitude {record['attitude']}, "
        f"{record['angle_deg']:g} deg{study})"
    )


def _foreign(path: Path, held: str, wanted: str) -> OutputError:
    return OutputError(f"'{path}' holds {held}, expected {wanted}: move the file away and --resume")


def _placeless(settings: Any) -> Any:
    """The settings without the places of files."""
    if not isinstance(settings, dict):
        return settings
    return {name: _placeless(value) for name, value in settings.items() if name not in PLACES}
