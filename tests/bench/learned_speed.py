"""What the learned controller costs beside the baseline: python -m tests.bench.learned_speed.

Flights of 100 s without a recording, the two controllers in turn, in processor time: the whole
flight (plant and sensing included, preparation left out), and single plans.
"""

import statistics
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from simsat.campaign.attitudes import spiral_attitudes
from simsat.flight.loop import fly
from simsat.flight.mission import prepare
from simsat.settings import FlightSettings


@dataclass(frozen=True)
class SpeedSettings:
    """Processor time of flights and plans."""

    model: Path = Path("two_wheel")
    flights: int = 10
    """Attitudes of the campaign, evenly taken."""
    period: float = 0.5
    """Control period, s."""
    controllers: tuple[str, ...] = ("nmpc", "nmpc-learned")


class Timed:
    """A planner whose plans are timed."""

    def __init__(self, planner: Any) -> None:
        self.planner = planner
        self.seconds: list[float] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self.planner, name)

    def plan(self, *arguments: Any) -> Any:
        """The plan, timed."""
        started = time.process_time()
        answer = self.planner.plan(*arguments)
        self.seconds.append(time.process_time() - started)
        return answer


def flown(settings: FlightSettings) -> tuple[float, list[float]]:
    """Seconds of processor time of a flight, and of each of its plans."""
    mission = prepare(settings)
    assert mission.pilot is not None
    planner = Timed(mission.pilot.planner)
    pilot = replace(mission.pilot, planner=planner)
    plant, periods, ticks = mission.build_plant(), mission.periods, mission.ticks_per_period
    started = time.process_time()
    fly(plant, pilot, periods, ticks, mission.sense)
    return time.process_time() - started, planner.seconds


def main(settings: SpeedSettings) -> None:
    """Print the table."""
    flights: dict[str, list[float]] = {name: [] for name in settings.controllers}
    plans: dict[str, list[float]] = {name: [] for name in settings.controllers}
    chosen = spiral_attitudes(100)[:: max(100 // settings.flights, 1)]
    base = FlightSettings(model=settings.model)
    base = replace(base, nmpc=replace(base.nmpc, period=settings.period))
    for k, attitude in enumerate([chosen[0], *chosen]):
        for name in settings.controllers:
            start = {"axis": attitude.axis, "angle_deg": attitude.angle_deg}
            seconds, each = flown(replace(base, controller=name, **start))  # type: ignore[arg-type]
            if k > 0:  # the first round warms caches
                flights[name].append(seconds)
                plans[name].extend(each)
    print("| controller | flight, s, median / max | plan, ms, median / 99 % / max | ratio |")
    print("| --- | --- | --- | --- |")
    first = statistics.median(flights[settings.controllers[0]])
    for name, times in flights.items():
        middle, ms = statistics.median(times), 1e3 * np.array(plans[name])
        print(
            f"| `{name}` | {middle:.3f} / {max(times):.3f} | {np.median(ms):.2f} / "
            f"{np.percentile(ms, 99):.1f} / {ms.max():.1f} | {middle / first:.2f} |"
        )


if __name__ == "__main__":
    main(tyro.cli(SpeedSettings, description=__doc__))
