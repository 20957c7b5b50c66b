"""Fly many attitudes under several controllers and compare them: python -m simsat.campaign --help.

Example: python -m simsat.campaign --controllers nmpc nmpc-pinn --attitudes paper --workers 2
"""

import contextlib
import os
import shlex
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro
from tqdm import tqdm

from simsat.appraisal.preview import preview
from simsat.campaign.attitudes import choose_attitudes
from simsat.campaign.carried import carry_points
from simsat.campaign.folder import identity, open_folder
from simsat.campaign.healing import survey
from simsat.campaign.recordings import record_chosen
from simsat.campaign.rows import finished, read_records, write_row
from simsat.campaign.run import FAILED, CampaignRun, RunResult, failed, fly_run, plan_runs
from simsat.campaign.study import grid, parse_variation, read_study
from simsat.command import parse
from simsat.comparison.results import write_campaign_results
from simsat.control.ground.errors import OutputError, SettingsError, SimsatError
from simsat.control.ground.settings import Settings
from simsat.flight.mission import prepare
from simsat.identity.difference import differences
from simsat.parallel.cluster import cluster_pool
from simsat.parallel.pool import Pool, PoolLostError, WorkerLostError, run_all
from simsat.parallel.processes import Workers, local_pool
from simsat.results.summary import foretell, left_out
from simsat.settings import CommonSettings, Names

INTERRUPTED = 3  # exit code of a campaign that can be resumed
NOTHING_FLEW = 1  # exit code of one whose every run failed


@dataclass(frozen=True)
class CampaignSettings(Settings):
    """Fly every controller from every attitude; all other settings hold for each run."""

    controllers: tuple[str, ...] = ("nmpc", "nmpc-pinn", "nmpc-pinn-supervisor", "nmpc-learned")
    """Controllers to compare by name, yours as package.module:name; an unknown name lists those
    that exist. The others are compared with nmpc, or with the first one if nmpc is not among
    them."""
    attitudes: str = "paper"
    """Initial attitudes: "paper" (100), a count spread evenly over the sphere, or a CSV file with
    the columns axis_x, axis_y, axis_z, angle_deg."""
    vary: Names = ()
    """Repeat the campaign for several values of a setting: NAME=VALUE,VALUE with the setting's name
    as in this list (nominal.mismatch=0,1,2). Several make a grid."""
    study: Path | None = None
    """TOML file that lists the values of settings to vary, one line per setting
    (nominal.mismatch = [0, 1, 2])."""
    workers: Workers | None = None
    """Processes on this machine; default one per core. The results do not depend on it."""
    cluster: str | None = None
    """Address of a Dask scheduler (tcp://host:port) to fly on instead of this machine."""
    recordings: Literal["worst", "all", "none"] = "worst"
    """Runs to keep with recording, time series and picture: the worst five of each controller, all
    or none."""
    out: Path | None = None
    """Folder to write, which must not exist yet; default a new one under runs/."""
    resume: bool = False
    """Go on with the folder --out, flying only what is missing; refused if its settings differ."""
    common: Annotated[CommonSettings, tyro.conf.arg(name="")] = field(
        default_factory=CommonSettings
    )

    def check(self) -> None:
        """Each controller once, and one place to fly."""
        if not self.controllers or len(set(self.controllers)) < len(self.controllers):
            raise SettingsError("--controllers needs one or more names, each once")
        if self.workers is not None and self.cluster is not None:
            raise SettingsError("--workers and --cluster exclude each other")
        if self.resume and self.out is None:
            raise SettingsError("--resume needs --out, the folder to go on with")


class CampaignStoppedError(SimsatError):
    """A campaign that was interrupted or lost its workers; what was flown is on disk."""

    def __str__(self) -> str:
        return Exception.__str__(self)  # with the command to go on with on a line of its own


def campaign(settings: CampaignSettings) -> int:
    """Fly what is missing, print the table; the exit code says whether it was brought to its
    end."""
    try:
        folder, records, table = fly_campaign(settings)
    except CampaignStoppedError as error:
        print(f"\n{error}", file=sys.stderr)
        return INTERRUPTED
    print(f"{table}\n{failures(records)}results in {folder}")
    return NOTHING_FLEW if all(map(has_failed, records)) else 0


def fly_campaign(settings: CampaignSettings) -> tuple[Path, list[dict[str, Any]], str]:
    """Fly what is missing, then write tables, pictures and recordings.

    Returns the folder, its rows and the table. Raises `CampaignStoppedError` that says how to go
    on, or `SimsatError` for what can't be flown.
    """
    starts = choose_attitudes(settings.attitudes)
    listed = () if settings.study is None else read_study(settings.study)
    points = grid((*listed, *map(parse_variation, settings.vary)))
    runs = plan_runs(settings.common, settings.controllers, starts, points)
    foretold = refuse_unflyable(runs)
    local = local_pool(settings.workers or os.cpu_count() or 1)
    pool = local if settings.cluster is None else cluster_pool(settings.cluster)
    mine = identity(settings.common, settings.controllers, starts, runs)
    with open_folder(settings.out, settings.resume, mine, settings) as folder:
        print("\n".join(foretold))
        try:
            carry_points(folder, runs)
            fly_missing(folder, runs, pool)
            records = read_records(folder)
            table = write_campaign_results(folder, records)
            record_chosen(folder, runs, records, settings.recordings, local)
        except (KeyboardInterrupt, PoolLostError, OSError) as error:
            raise CampaignStoppedError(_stopped(error, folder, len(runs))) from error
    return folder, records, table


def failures(records: list[dict[str, Any]]) -> str:
    """How many runs failed and what can be done; empty if none did."""
    count = sum(map(has_failed, records))
    if count == 0:
        return ""
    return (
        f"{count} of {len(records)} runs failed and say why in rows/; to fly them again, delete "
        "their files there and --resume\n"
    )


def has_failed(record: dict[str, Any]) -> bool:
    """Whether a run raised, or its process died, instead of flying."""
    return record["metrics"]["ending"] == FAILED


def refuse_unflyable(runs: tuple[CampaignRun, ...]) -> list[str]:
    """Prepare one run of each controller and point: bad settings end here, not in every row.

    This also compiles each planner once, before the workers ask for it. Returns what is known of
    them beforehand, each line once.
    """
    foretold: dict[str, None] = {}
    first = {(run.settings.controller, *run.point.items()): run for run in reversed(runs)}
    for run in tqdm(list(reversed(first.values())), desc="preparing", leave=False, disable=None):
        mission = prepare(run.settings)
        head = f"{mission.model.spacecraft.name}, {run.settings.controller}:"
        lines = [head, *left_out(mission), foretell(preview(mission))]
        foretold["\n".join(lines)] = None
    return list(foretold)


def fly_missing(folder: Path, runs: tuple[CampaignRun, ...], pool: Pool) -> None:
    """Fly every run that has no row yet; each row is on disk as soon as its run ends."""
    found = survey(folder, runs)
    for remark in found.remarks:
        print(remark)
    missing = [run for run in runs if run.index not in found.done]
    failures = 0
    with (
        progress(len(runs), len(found.done), pool.name) as bar,
        contextlib.closing(run_all(pool, fly_run, missing)) as results,
    ):
        for run, result in results:
            kept = failed(run, str(result)) if isinstance(result, WorkerLostError) else result
            refuse_changed(run, kept)
            write_row(folder, run.index, kept)
            failures += not complete(kept)
            bar.set_postfix(failed=failures, refresh=False)
            bar.update()


def refuse_changed(run: CampaignRun, result: RunResult) -> None:
    """A row flown with other files or by another machine's code ends the campaign: no table mixes
    them. Raises `OutputError` that names the worker and what differs."""
    flown_with = result.record["flown_with"]
    differing = [] if flown_with is None else differences(run.flown_with, flown_with)
    if differing:
        worker = result.record["timing"]["worker"]
        raise OutputError(
            f"the worker {worker} flew run {run.index} with something else than this campaign "
            f"began with ({'; '.join(differing)}); put that back and --resume"
        )


def progress(total: int, done: int, name: str) -> tqdm:
    """A bar on a terminal; in a log file, a line every half minute."""
    interval = 0.1 if sys.stderr.isatty() else 30.0
    return tqdm(total=total, initial=done, unit="run", desc=name, mininterval=interval)


def complete(result: RunResult) -> bool:
    """Whether the run was flown to its end."""
    return result.record["metrics"]["ending"] == "complete"


def _stopped(error: BaseException, folder: Path, runs: int) -> str:
    why = str(error) or "interrupted"
    done = len(finished(folder))
    return f"{why}, with {done} of {runs} runs on disk; go on with\n  {resume_command(folder)}"


def resume_command(folder: Path) -> str:
    """The command line that goes on with this campaign."""
    words = ["python", "-m", "simsat.campaign", *sys.argv[1:]]
    if not any(word.split("=")[0] == "--out" for word in words):
        words += ["--out", str(folder)]
    if "--resume" not in words:
        words.append("--resume")
    return shlex.join(words)


def main() -> int:
    """The command line."""
    return campaign(parse(CampaignSettings, __doc__))
