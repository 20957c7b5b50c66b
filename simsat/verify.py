"""Fly kept results again and compare them to the last bit: python -m simsat.verify FOLDER --help.

The folder is a run's, a replay's or a campaign's. Exit code 0 says that everything came out again,
1 that something did not, 2 that there is nothing to compare.
"""

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import pyarrow as pa
import pyarrow.parquet as pq
import tyro
from tqdm import tqdm

from simsat.campaign.carried import Places, places_in
from simsat.campaign.folder import IDENTITY
from simsat.campaign.rows import read_records, trajectory_path
from simsat.campaign.run import FAILED, CampaignRun, fly_run, repeatable
from simsat.command import command, parse
from simsat.control.ground.errors import OutputError
from simsat.control.ground.settings import Count, Settings
from simsat.flight.loop import Ending
from simsat.flight.mission import Mission, prepare
from simsat.identity.difference import differences
from simsat.identity.flight import expected_identity, mission_identity
from simsat.parallel.pool import WorkerLostError, run_all
from simsat.parallel.processes import Workers, local_pool
from simsat.replay import ReplaySettings, prepare_replay
from simsat.results.comparing import Difference, compared
from simsat.results.copies import copies_in, with_copies
from simsat.results.flight_result import FlightResult
from simsat.results.folder import METRICS, SERIES, SETTINGS
from simsat.results.saved import read_json, settings_from_json
from simsat.settings import FlightSettings

SERIES_GROUP = "series"
DIFFERENT = 1  # exit code


@dataclass(frozen=True)
class Verification:
    """What flying again came to."""

    flown: int
    """Flights that were flown again."""
    changed: tuple[str, ...]
    """What is not as it was when the results were made, a phrase each."""
    differences: tuple[Difference, ...]
    """Every figure that did not come out again."""

    @property
    def same(self) -> bool:
        """Whether all of them came out again, to the last bit."""
        return not self.differences

    def __str__(self) -> str:
        lines = [f"not as it was: {phrase}" for phrase in self.changed]
        if self.same:
            return "\n".join([*lines, f"{self.flown} flown again: the same to the last bit"])
        worst = dict[str, Difference]()
        for difference in self.differences:
            known = worst.get(difference.name)
            if known is None or difference.size > known.size:
                worst[difference.name] = difference
        runs = len({difference.where for difference in self.differences})
        lines.append(f"{runs} of {self.flown} flown again came out otherwise, at most by")
        return "\n".join([*lines, *(f"  {difference}" for difference in worst.values())])


@dataclass(frozen=True)
class VerifySettings(Settings):
    """Fly kept results again and compare metrics and series with those in the folder."""

    folder: Annotated[Path, tyro.conf.Positional]
    """Folder of a run, a replay or a campaign."""
    rows: Count | None = None
    """How many of a campaign's runs to fly, spread evenly over it; default all."""
    workers: Workers | None = None
    """Processes for a campaign's runs; default one per core."""


def verify(folder: Path, rows: int | None = None, workers: int | None = None) -> Verification:
    """Fly what a folder holds again.

    Of a campaign `rows` runs, spread evenly, on so many `workers`; by default all, on all cores.
    Raises `OutputError` for a folder that holds no results or damaged ones.
    """
    if os.path.isfile(folder / IDENTITY):
        return _verify_campaign(folder, rows, workers or os.cpu_count() or 1)
    if os.path.isfile(folder / SETTINGS):
        return _verify_run(folder)
    raise OutputError(
        f"'{folder}' is no folder of a run or a campaign: it has neither {SETTINGS} nor {IDENTITY}"
    )


def _verify_run(folder: Path) -> Verification:
    saved = read_json(folder / SETTINGS)
    kept = read_json(folder / METRICS)
    if kept.get("ending") == Ending.INTERRUPTED.name.lower():
        raise OutputError(f"the run in '{folder}' was interrupted: there is no whole one to repeat")
    mission, asked = _mission(saved.get("settings"), folder / SETTINGS, copies_in(saved))
    result = FlightResult(mission, mission.fly())
    flown = repeatable(result.metrics)
    series = _read_series(folder / SERIES)
    changed = differences(saved.get("flown_with") or {}, mission_identity(mission, asked))
    found = compared(
        folder.name,
        repeatable(kept) | {SERIES_GROUP: _columns(series)},
        flown | {SERIES_GROUP: _columns(result.table)},
    )
    return Verification(1, tuple(changed), tuple(found))


def _mission(settings: Any, where: Path, copies: dict[str, str]) -> tuple[Mission, Any]:
    """The mission that a run's or a replay's settings describe, and those settings."""
    if isinstance(settings, dict) and "profile" in settings:
        replay = settings_from_json(ReplaySettings, settings, where)
        return prepare_replay(replay), replay
    flight = settings_from_json(FlightSettings, settings, where)
    return prepare(with_copies(flight, where.parent, copies)), flight


def _verify_campaign(folder: Path, rows: int | None, workers: int) -> Verification:
    """Runs that failed have nothing to compare and are left out."""
    flown = [r for r in read_records(folder) if r["metrics"]["ending"] != FAILED]
    if not flown:
        raise OutputError(f"no run in '{folder}' was flown: there is nothing to compare")
    chosen = flown if rows is None else _spread(flown, rows)
    records = {record["run"]: record for record in chosen}
    places = places_in(folder)
    runs = [_run(record, folder, places) for record in chosen]
    found, changed = list[Difference](), dict[str, None]()
    with tqdm(total=len(chosen), unit="run", desc="flown again", disable=None) as bar:
        for run, result in run_all(local_pool(min(workers, len(chosen))), fly_run, runs):
            if isinstance(result, WorkerLostError):
                raise OutputError(f"{run.name}: {result}")
            kept = records[run.index]
            series = _read_series(trajectory_path(folder, run.index))
            found += compared(
                run.name,
                kept["metrics"] | {SERIES_GROUP: _columns(series)},
                result.record["metrics"] | {SERIES_GROUP: _columns(result.trajectory)},
            )
            now = result.record["flown_with"] or expected_identity(run.settings)
            changed |= dict.fromkeys(differences(kept["flown_with"], now))
            bar.update()
    return Verification(len(chosen), tuple(changed), tuple(found))


def _run(record: dict[str, Any], folder: Path, places: Places) -> CampaignRun:
    """The run, of what the folder carries."""
    settings = settings_from_json(FlightSettings, record["settings"], folder)
    settings = with_copies(settings, folder, places.get(record["study"], {}))
    place = (record["run"], record["attitude"], record["point"])
    return CampaignRun(*place, settings, record["flown_with"])


def _spread(records: list[dict[str, Any]], count: int) -> list[dict[str, Any]]:
    count = min(count, len(records))
    return [records[i * len(records) // count] for i in range(count)]


def _read_series(path: Path) -> pa.Table:
    try:
        return pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise OutputError(f"can't read '{path}': {error}") from error


def _columns(table: pa.Table | None) -> dict[str, Any]:
    return {} if table is None else {n: table[n].to_numpy() for n in table.column_names}


def main() -> int:
    """The command line."""
    settings = parse(VerifySettings, __doc__)
    verification = verify(settings.folder, settings.rows, settings.workers)
    print(verification)
    return 0 if verification.same else DIFFERENT


if __name__ == "__main__":
    sys.exit(command(main))
