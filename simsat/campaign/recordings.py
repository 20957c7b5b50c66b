"""Recordings of chosen runs of a campaign: flown again, which also shows that they repeat."""

import contextlib
import math
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from simsat.campaign.run import FAILED, CampaignRun, record_run
from simsat.control.ground.errors import OutputError
from simsat.parallel.pool import Pool, WorkerLostError, run_all
from simsat.results.folder import METRICS, RECORDING
from simsat.results.saved import read_json

RECORDINGS = "recordings"
WORST = 5  # of each controller


@dataclass(frozen=True)
class _Job:
    run: CampaignRun
    folder: Path


def record_chosen(
    folder: Path,
    runs: tuple[CampaignRun, ...],
    records: list[dict[str, Any]],
    which: str,
    pool: Pool,
) -> None:
    """Write recordings/NAME/ for the worst five of each controller, all runs, or none.

    Folders that are there already and whole are kept. Runs that failed have nothing to record.
    """
    chosen = _chosen(records, which)
    jobs = [_Job(run, folder / RECORDINGS / run.name) for run in runs if run.index in chosen]
    jobs = [job for job in jobs if not _is_whole(job.folder)]
    with (
        tqdm(jobs, unit="run", desc="recordings", total=len(jobs), disable=not jobs) as bar,
        contextlib.closing(run_all(pool, _record, jobs)) as results,
    ):
        for job, metrics in results:
            bar.update()
            if isinstance(metrics, WorkerLostError):
                print(f"no recording of {job.run.name}: {metrics}")
            elif metrics != chosen[job.run.index]:
                print(f"{job.run.name} did not repeat: its recording's metrics differ from its row")


def _is_whole(folder: Path) -> bool:
    """Whether an earlier call left a recording and metrics that can be read."""
    try:
        read_json(folder / METRICS)
    except OutputError:
        return False
    return (folder / RECORDING).is_file()


def worst(records: list[dict[str, Any]], count: int = WORST) -> list[dict[str, Any]]:
    """The `count` worst runs of each controller: not converged first, then by final error."""
    controllers = dict.fromkeys(record["controller"] for record in records)
    chosen = []
    for controller in controllers:
        flown = [r for r in records if r["controller"] == controller]
        chosen += sorted(flown, key=_badness, reverse=True)[:count]
    return chosen


def _badness(record: dict[str, Any]) -> tuple[bool, float]:
    metrics = record["metrics"]
    error = metrics["final_error_deg"]
    return not metrics["converged"], math.inf if error is None else error


def _chosen(records: list[dict[str, Any]], which: str) -> dict[int, dict[str, Any]]:
    """Metrics by run index."""
    flown = [record for record in records if record["metrics"]["ending"] != FAILED]
    listed = {"all": flown, "worst": worst(flown), "none": []}[which]
    return {record["run"]: record["metrics"] for record in listed}


def _record(job: _Job) -> dict[str, Any]:
    """In a worker: into a folder that gets its name only when it is complete."""
    part = job.folder.with_name(f"{job.folder.name}.part")
    if part.exists():
        shutil.rmtree(part)
    part.mkdir(parents=True)
    metrics = record_run(job.run, part)
    if job.folder.exists():  # damaged
        shutil.rmtree(job.folder)
    part.rename(job.folder)
    return metrics
