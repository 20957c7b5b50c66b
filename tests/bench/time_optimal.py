"""How close the learned controller comes to the shortest slew there is.

    python -m tests.bench.time_optimal [--every 5] [--controller nmpc-learned]

For every fifth direction of the campaign (75 and 125 degrees): the shortest rest-to-rest slew
with the exact inertia, unlimited torque rate and no environment (free end time, 60 intervals, the
best of eight guesses), and the settling time of a flight on the MuJoCo plant, whose motors ramp at
0.4 Nm/s and whose controller starts from the nominal inertia. A settling time is the start of the
stretch below 0.5 degrees, so it can fall short of the time to rest exactly.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import tyro

from simsat.control.learned.guidance.minimum_time import (
    BoundaryValues,
    build_minimum_time,
    solve_minimum_time,
)
from simsat.control.model.momentum import MomentumModel
from simsat.flight.mission import prepare
from simsat.results.metrics import judge
from simsat.settings import FlightSettings

GUESSES = 8


@dataclass(frozen=True)
class TimeOptimalSettings:
    """Settling times against the shortest slews of the same attitudes."""

    every: int = 5
    """Take every so many directions of the campaign's 50."""
    controller: str = "nmpc-learned"
    """The controller to fly."""


def direction(i: int) -> tuple[float, float, float]:
    """Number i of 50 Fibonacci directions."""
    z, longitude = 1.0 - (2 * i + 1) / 50.0, i * math.pi * (3.0 - math.sqrt(5.0))
    radius = math.sqrt(1.0 - z * z)
    return radius * math.cos(longitude), radius * math.sin(longitude), z


def shortest(settings: FlightSettings) -> float:
    """Duration of the shortest slew, s, sought in the craft's own units."""
    truth = prepare(replace(settings, controller="nmpc")).model.spacecraft
    units = truth.own_units
    craft = truth.in_units(units)
    model = MomentumModel(craft, craft.J, np.array([0.0, 0.0, 0.0]))
    problem = build_minimum_time(craft, intervals=60)
    rest = np.zeros(craft.wheels)
    values = BoundaryValues(settings.q_start, rest, settings.q_target, craft.torque_max)
    found = [solve_minimum_time(problem, model, values, guess) for guess in range(GUESSES)]
    return min(one.duration for one in found if one is not None) * units.time


def settling(settings: FlightSettings) -> float:
    """Settling time of a flight, s; NaN if it does not converge."""
    mission = prepare(settings)
    time = judge(mission.fly(), mission.target)["settling_time_s"]
    return math.nan if time is None else time


def main(settings: TimeOptimalSettings) -> None:
    """Print the table."""
    rows = []
    print("| direction | angle, deg | shortest, s | settling, s | ratio |\n|---|---|---|---|---|")
    for angle in (75.0, 125.0):
        for i in range(0, 50, settings.every):
            flight = FlightSettings(
                controller=settings.controller, axis=direction(i), angle_deg=angle
            )
            best, flown = shortest(flight), settling(flight)
            rows.append((best, flown, flown / best))
            print(
                f"| {i} | {angle:g} | {best:.2f} | {flown:.2f} | {flown / best:.3f} |", flush=True
            )
    best, flown, ratio = np.array(rows).T
    print(f"| mean | | {best.mean():.2f} | {flown.mean():.2f} | {ratio.mean():.3f} |")
    print(f"| max | | {best.max():.2f} | {flown.max():.2f} | {ratio.max():.3f} |")


if __name__ == "__main__":
    main(tyro.cli(TimeOptimalSettings, description=__doc__))
