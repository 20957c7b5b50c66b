"""How a campaign scales with workers, and whether its memory stays flat.

    python -m tests.bench.campaign_speed [RUNS]

Flies the same runs (default 100, nmpc) with one and with two workers by turns, three times each,
and prints runs per second, the best of each: other load on the machine only ever slows a turn down.
Then flies 400 runs on one worker and prints its resident memory on the way (Linux).
"""

import multiprocessing
import sys
import time
from pathlib import Path

from simsat.campaign.attitudes import spiral_attitudes
from simsat.campaign.run import CampaignRun, fly_run, plan_runs
from simsat.parallel.pool import run_all
from simsat.parallel.processes import local_pool
from simsat.settings import FlightSettings

TURNS = 3
MEMORY_RUNS = 400
REPORTED = (20, 100, 200, 300, 400)


def runs_of(count: int) -> tuple[CampaignRun, ...]:
    """So many runs of the baseline."""
    return plan_runs(FlightSettings(), ("nmpc",), spiral_attitudes(count), ({},))


def seconds(runs: tuple[CampaignRun, ...], workers: int) -> float:
    """Wall time of a campaign, the start of the workers included."""
    started = time.perf_counter()
    for _ in run_all(local_pool(workers), fly_run, runs):
        pass
    return time.perf_counter() - started


def resident_mb(pid: int) -> float:
    """Resident memory of a process, MB."""
    status = Path(f"/proc/{pid}/status").read_text()
    (line,) = (line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024.0


def main() -> None:
    """Print both measurements."""
    runs = runs_of(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
    turns = [(seconds(runs, 1), seconds(runs, 2)) for _ in range(TURNS)]
    one, two = (min(turn[i] for turn in turns) for i in (0, 1))
    print(f"{len(runs)} runs: 1 worker {one:.1f} s, 2 workers {two:.1f} s, {one / two:.2f} times")
    for done, _ in enumerate(run_all(local_pool(1), fly_run, runs_of(MEMORY_RUNS)), start=1):
        if done in REPORTED:
            (worker,) = multiprocessing.active_children()
            print(f"after {done} runs: worker {resident_mb(worker.pid or 0):.0f} MB")


if __name__ == "__main__":
    main()
