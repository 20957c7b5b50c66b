"""A closed-loop flight of 100 s, side by side in one process: python -m tests.bench.closed_loop.

Interleaved: the flight alone, the flight with a recording, and bare mj_step over as many steps.
"""

import statistics
import tempfile
import time
from pathlib import Path

import mujoco

from simsat.flight.mission import prepare
from simsat.recording.recorder import Recorder
from simsat.settings import FlightSettings

REPEATS = 7


def alone() -> float:
    """Seconds of one unrecorded flight, start-up excluded."""
    mission = prepare(FlightSettings())
    started = time.perf_counter()
    mission.fly()
    return time.perf_counter() - started


def recorded() -> float:
    """Seconds of one recorded flight, opening and closing the file included."""
    mission = prepare(FlightSettings())
    with tempfile.TemporaryDirectory() as folder:
        started = time.perf_counter()
        with Recorder(Path(folder) / "recording.rrd", mission, "") as recorder:
            mission.fly(recorder.follow)
        return time.perf_counter() - started


def bare() -> float:
    """Seconds of the same physics steps without anything around them."""
    m = prepare(FlightSettings()).model.mj
    d = mujoco.MjData(m)
    started = time.perf_counter()
    for _ in range(10_000):
        mujoco.mj_step(m, d)
    return time.perf_counter() - started


def main() -> None:
    """Print the medians and their ratios."""
    cases = {"flight alone": alone, "flight recorded": recorded, "bare mj_step": bare}
    times: dict[str, list[float]] = {name: [] for name in cases}
    for repeat in range(REPEATS + 1):
        for name, case in cases.items():
            seconds = case()
            if repeat > 0:  # the first round warms caches
                times[name].append(seconds)
    medians = {name: statistics.median(values) for name, values in times.items()}
    print(f"| 100 simulated seconds, median of {REPEATS} | s | ratio to the flight alone |")
    print("| --- | --- | --- |")
    for name, seconds in medians.items():
        print(f"| {name} | {seconds:.3f} | {seconds / medians['flight alone']:.3f} |")


if __name__ == "__main__":
    main()
