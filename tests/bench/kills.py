"""Kill campaigns and runs at random moments and see that nothing is lost.

    python -m tests.bench.kills [KILLS] [SEED]

A small campaign on two workers is stopped by SIGKILL, SIGTERM or SIGINT at a random moment, resumed
and stopped again, three times, then left alone: its tables must be those of an undisturbed one, no
row that was there may be flown again, and no process may be left. A run is stopped in the same way:
what it leaves must be whole. Prints counts; a kill that breaks a promise raises.
"""

import contextlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pyarrow.parquet as pq

from simsat.campaign.rows import finished, read_row
from simsat.command import BROKEN_OFF
from tests.places import ROOT

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
KILLS_PER_FOLDER = 3
FLAGS = ("--controllers", "nmpc", "--attitudes", "6", "--duration-s", "4", "--workers", "2",
         "--recordings", "none")  # fmt: skip
RUN_FLAGS = ("--duration-s", "60")
TABLES = ("results.parquet", "trajectories.parquet")
FINISHED = re.compile(r"^(results?|network) in ", re.MULTILINE)  # what a command says at its end
PYTHON_STARTS_S = 0.1  # until our first line runs, Python answers signals in its own way
PATIENCE_S = 20.0  # for processes to be gone


def start(module: str, out: Path, *flags: str) -> subprocess.Popen[str]:
    """A command in a session of its own, so that all its processes can be found; it takes Ctrl-C
    even if this process runs in the background and ignores it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    return subprocess.Popen(
        [sys.executable, "-m", module, *flags, "--out", str(out)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip


def processes_of(session: int) -> Iterator[int]:
    """Every process of a session that still runs."""
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
            if int(fields[3]) == session and fields[0] != "Z":
                yield int(folder.name)


def require_gone(session: int) -> None:
    """Raise if a process outlives its command."""
    end = time.monotonic() + PATIENCE_S
    while left := list(processes_of(session)):
        if time.monotonic() > end:
            for pid in left:
                os.kill(pid, signal.SIGKILL)
            raise AssertionError(f"processes {left} were left")
        time.sleep(0.05)


def kill(process: subprocess.Popen[str], after_s: float, how: signal.Signals) -> str:
    """Stop a command; how it ended, in words."""
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(after_s)
    ended = process.poll() is not None
    process.send_signal(how)  # to nobody, if it has ended
    out, said = process.communicate(timeout=120.0)
    require_gone(process.pid)
    left = FINISHED.search(out) is not None  # Python was leaving, which no handler hears
    untold = "Traceback" in said or not (left or process.returncode in (0, BROKEN_OFF))
    if how is not signal.SIGKILL and untold and after_s > PYTHON_STARTS_S:
        raise AssertionError(f"{how.name} after {after_s:.3f} s, {process.returncode}: {said}")
    return "had ended already" if ended or left else f"{how.name}, exit code {process.returncode}"


def timed(module: str, out: Path, *flags: str) -> float:
    """Wall time of an undisturbed command."""
    started = time.monotonic()
    process = start(module, out, *flags)
    _, said = process.communicate()
    if process.returncode != 0:
        raise AssertionError(said)
    require_gone(process.pid)
    return time.monotonic() - started


def kill_campaigns(kills: int, seed: int, folder: Path) -> Counter[str]:
    """So many kills, three to a folder; counts of how they ended."""
    chance = random.Random(seed)
    whole = folder / "whole"
    length = timed("simsat.campaign", whole, *FLAGS)
    counts = Counter[str]()
    for number in range(0, kills, KILLS_PER_FOLDER):
        out = folder / f"campaign_{number}"
        for _ in range(min(KILLS_PER_FOLDER, kills - number)):
            before = sound_rows(out)
            how = chance.choice(SIGNALS)
            process = start("simsat.campaign", out, *FLAGS, "--resume")
            counts[kill(process, chance.uniform(0.0, length), how)] += 1
            require_kept(before, out)
        before = sound_rows(out)
        timed("simsat.campaign", out, *FLAGS, "--resume")
        require_kept(before, out)
        for name in TABLES:
            if not pq.read_table(out / name).equals(pq.read_table(whole / name)):
                raise AssertionError(f"{out / name} differs from an undisturbed campaign's")
    return counts


def sound_rows(out: Path) -> dict[int, int]:
    """Rows on disk, each read whole, with the time they were written."""
    for index in finished(out):
        read_row(out, index)
    return {i: (out / "rows" / f"{i:05d}.json").stat().st_mtime_ns for i in finished(out)}


def require_kept(before: dict[int, int], out: Path) -> None:
    """Raise if a row was lost or flown again."""
    after = sound_rows(out)
    if any(after.get(index) != written for index, written in before.items()):
        raise AssertionError(f"rows of {out} were lost or flown again")


def kill_runs(kills: int, seed: int, folder: Path) -> Counter[str]:
    """Runs stopped once each; whatever file they leave is whole."""
    chance = random.Random(seed)
    length = timed("simsat.run", folder / "run_whole", *RUN_FLAGS)
    counts = Counter[str]()
    for number in range(kills):
        out = folder / f"run_{number}"
        how = chance.choice(SIGNALS)
        process = start("simsat.run", out, *RUN_FLAGS)
        counts[kill(process, chance.uniform(0.0, length), how)] += 1
        for path in out.glob("*"):
            if path.suffix == ".json":
                json.loads(path.read_text())
            elif path.suffix == ".parquet":
                pq.read_table(path)
    return counts


def main() -> None:
    """Kill, and print how it went."""
    kills = int(sys.argv[1]) if len(sys.argv) > 1 else 30
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with tempfile.TemporaryDirectory() as folder:
        for name, counts in (
            ("campaigns", kill_campaigns(kills, seed, Path(folder))),
            ("runs", kill_runs(kills, seed, Path(folder))),
        ):
            print(f"{name}: {counts.total()} kills, nothing lost, no process left")
            for ending, count in sorted(counts.items()):
                print(f"  {count:3d}  {ending}")


if __name__ == "__main__":
    main()
