"""Settling times of spacecraft of all sizes against the shortest slews there are.

    python -m tests.bench.any_size [--models hubble kepler_two_wheel ...] [--attitudes 10]
        [--controllers nmpc nmpc-learned] [--alone]

For each spacecraft, controller and initial attitude (spread over the sphere, half of them 75 and
half 125 degrees off): the settling time over the duration of the shortest rest-to-rest slew with
the exact inertia, unlimited torque rate and no environment (`time_optimal`). What a flight that
did not converge came to is said below its row. `--alone` leaves the environment out.
"""

import math
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tyro

from simsat.campaign.attitudes import InitialRotation, spiral_attitudes
from simsat.environment import EnvironmentSettings
from simsat.flight.mission import Mission, prepare
from simsat.mjcf.shipped import shipped_models
from simsat.results.flight_result import FlightResult
from simsat.settings import FlightSettings
from tests.bench.time_optimal import shortest


@dataclass(frozen=True)
class AnySizeSettings:
    """Settling times against the shortest slews, spacecraft by spacecraft."""

    models: tuple[Path, ...] = tuple(map(Path, shipped_models()))
    """The spacecraft; all that are shipped by default."""
    controllers: tuple[str, ...] = ("nmpc", "nmpc-learned")
    """The controllers to fly."""
    attitudes: int = 10
    """Initial attitudes, half of them 75 and half 125 degrees off."""
    alone: bool = False
    """Without an environment."""


def flights(settings: AnySizeSettings, model: Path, controller: str) -> list[FlightSettings]:
    """What to fly of a spacecraft under a controller."""
    environment = EnvironmentSettings()
    if settings.alone:
        environment = EnvironmentSettings(gravity_gradient=False, drag=False)
    base = FlightSettings(model=model, controller=controller, environment=environment)
    return [starting(base, start) for start in spiral_attitudes(settings.attitudes)]


def starting(base: FlightSettings, start: InitialRotation) -> FlightSettings:
    """The flight from an initial rotation."""
    return replace(base, axis=start.axis, angle_deg=start.angle_deg)


def row(mission: Mission, ratios: list[float], worst_ms: float, median_ms: float) -> str:
    """A line of the table."""
    craft, found = mission.model.spacecraft, np.array([r for r in ratios if math.isfinite(r)])
    mean, most = (f"{found.mean():.3f}", f"{found.max():.3f}") if len(found) else ("-", "-")
    period_ms = 1e3 * mission.timing.period_s
    return (
        f"| {craft.name} | {craft.wheels} | {mission.timing.units.natural_time:.4g} "
        f"| {mission.settings.controller} | {len(found)} / {len(ratios)} | {mean} | {most} "
        f"| {median_ms:.2f} ({100 * median_ms / period_ms:.2g} %) | {worst_ms:.1f} |"
    )


def main(settings: AnySizeSettings) -> None:
    """Print the table."""
    print("| spacecraft | wheels | T0, s | controller | converged | over the shortest, mean | max "
          "| plan, ms (of the period) | longest, ms |\n" + "| --- " * 9 + "|")  # fmt: skip
    for model in settings.models:
        bounds: list[float] = []
        for controller in settings.controllers:
            planned = flights(settings, model, controller)
            bounds = bounds or [shortest(flight) for flight in planned]
            missions = [prepare(flight) for flight in planned]
            metrics = [FlightResult(mission, mission.fly()).metrics for mission in missions]
            times = [m["settling_time_s"] for m in metrics]
            ratios = [math.nan if t is None else t / b for t, b in zip(times, bounds, strict=True)]
            plans = [m["solve_time_ms"] for m in metrics]
            median = float(np.median([p["median"] for p in plans]))
            print(row(missions[0], ratios, max(p["max"] for p in plans), median), flush=True)
            lost = Counter(m["convergence"] for m in metrics if not m["converged"])
            for sentence, count in lost.items():
                print(f"    {count}: {sentence}", flush=True)


if __name__ == "__main__":
    main(tyro.cli(AnySizeSettings, description=__doc__))
