"""Kill trainings at random moments and see that they come to the same weights.

    python -m tests.bench.training_kills [KILLS] [SEED]

A small training of each kind is stopped by SIGKILL, SIGTERM or SIGINT at a random moment, called
again and stopped again, three times, then left alone: its networks, flights and report must be
those of an undisturbed one, to the last byte. After every kill each file that lies there must be
whole, no flight may be lost or flown again, and no process may be left. Prints counts; a kill that
breaks a promise raises.
"""

import json
import random
import sys
import tempfile
from collections import Counter
from pathlib import Path

import torch
from safetensors.numpy import load_file

from simsat.learning.files import read_telemetry
from simsat.results.files import PART
from tests.bench.kills import KILLS_PER_FOLDER, SIGNALS, kill, start, timed

TRAININGS = {
    "learning.train": ("--flights", "6", "6", "--duration-s", "6", "--fit.epochs", "40"),
    "learning.train_appendage": (
        "--flights", "6", "6", "--duration-s", "16", "--fit.epochs", "6", "--fit.width", "6",
        "--fit.gates", "2",
    ),
}  # fmt: skip
SAME = ("*.safetensors", "flights_*/*.npz", "report.json", "report.md")


def kill_trainings(module: str, kills: int, seed: int, folder: Path) -> Counter[str]:
    """So many kills, three to a folder; counts of how they ended."""
    chance, flags = random.Random(f"{module}{seed}"), TRAININGS[module]
    whole = folder / f"{module}_whole"
    length = timed(module, whole, *flags)
    counts = Counter[str]()
    while counts.total() < kills:
        out = folder / f"{module}_{counts.total()}"
        for _ in range(min(KILLS_PER_FOLDER, kills - counts.total())):
            before = sound_flights(out)
            how, after_s = chance.choice(SIGNALS), chance.uniform(0.0, length)
            counts[kill(start(module, out, *flags), after_s, how)] += 1
            require_sound(out)
            require_kept(before, out)
        before = sound_flights(out)
        timed(module, out, *flags)
        require_kept(before, out)
        require_same(out, whole)
    return counts


def sound_flights(out: Path) -> dict[Path, int]:
    """Flights on disk, each read whole, with the time they were written."""
    flights = sorted(out.glob("flights_*/*.npz"))
    for path in flights:
        read_telemetry(path)
    return {path: path.stat().st_mtime_ns for path in flights}


def require_kept(before: dict[Path, int], out: Path) -> None:
    """Raise if a flight was lost or flown again."""
    after = sound_flights(out)
    if any(after.get(path) != written for path, written in before.items()):
        raise AssertionError(f"flights of {out} were lost or flown again")


def require_sound(out: Path) -> None:
    """Read every file that a kill left, but for those that are named as unfinished."""
    for path in (p for p in out.rglob("*") if p.is_file() and p.suffix != PART):
        if path.suffix == ".json":
            json.loads(path.read_text())
        elif path.suffix == ".pt":
            torch.load(path, weights_only=True)
        elif path.suffix == ".safetensors":
            load_file(path)
        elif path.suffix == ".png":
            assert path.read_bytes().endswith(b"IEND\xaeB`\x82"), path


def require_same(out: Path, whole: Path) -> None:
    """Raise if anything that was trained differs, or an unfinished file is left."""
    wanted = {p.relative_to(whole) for p in whole.rglob("*") if p.is_file()}
    found = {p.relative_to(out) for p in out.rglob("*") if p.is_file()}
    if found != wanted:
        raise AssertionError(f"{out} holds other files: {sorted(map(str, found ^ wanted))}")
    for path in (p for pattern in SAME for p in whole.glob(pattern)):
        if (out / path.relative_to(whole)).read_bytes() != path.read_bytes():
            raise AssertionError(f"{out / path.relative_to(whole)} differs from an undisturbed one")


def main() -> None:
    """Kill, and print how it went."""
    kills = int(sys.argv[1]) if len(sys.argv) > 1 else 24
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with tempfile.TemporaryDirectory() as folder:
        for module in TRAININGS:
            counts = kill_trainings(module, kills, seed, Path(folder))
            print(f"{module}: {counts.total()} kills, same weights, no process left")
            for ending, count in sorted(counts.items()):
                print(f"  {count:3d}  {ending}", flush=True)


if __name__ == "__main__":
    main()
