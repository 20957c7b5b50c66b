"""Training flights: which ones, flown and kept as telemetry at 20 Hz."""

import contextlib
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import numpy as np
from tqdm import tqdm

from simsat.campaign.attitudes import choose_attitudes
from simsat.control.ground import attitude
from simsat.control.ground.arrays import Quaternion
from simsat.control.ground.errors import OutputError
from simsat.control.ground.own import Own, own
from simsat.control.ground.settings import Count, CountOrNone, Positive, Settings
from simsat.control.learned.settings import LearnedSettings
from simsat.flight.loop import Ending
from simsat.flight.mission import prepare
from simsat.parallel.pool import run_all
from simsat.parallel.processes import local_pool
from simsat.settings import FlightSettings, NominalSettings

from ..files import read_telemetry, write_telemetry
from .windows import Telemetry

CLEARANCE = math.radians(5.0)  # no training flight starts closer to a campaign attitude


@dataclass(frozen=True)
class FleetSettings(Settings):
    """Which training flights are flown."""

    model: Path = FlightSettings.model
    """The spacecraft: an MJCF file, or the name of one in models/."""
    nominal: NominalSettings = field(default_factory=NominalSettings)
    flights: Count = 48
    """How many flights; each starts at rest, at an attitude drawn uniformly from all those at least
    5 degrees away from every attitude of the campaign."""
    duration_s: Annotated[Positive | None, Own("time", 40.0)] = None
    """Length of each flight, s: as long as the error is usually above a degree; some 40 of the
    craft's own seconds unless given."""
    seed: CountOrNone = 0
    """Decides all starting attitudes."""


def fly_fleet(
    folder: Path,
    fleet: FleetSettings,
    workers: int,
    controller: str = FlightSettings.controller,
    network: str = FlightSettings.network,
) -> list[Telemetry]:
    """Telemetry of every flight, from the folder where it is already there; under the baseline or
    another controller. None flies the appendage network beside the model: data for the next one
    must not depend on the last."""
    folder.mkdir(parents=True, exist_ok=True)
    base = FlightSettings(
        model=fleet.model,
        controller=controller,
        network=network,
        nominal=fleet.nominal,
        learned=LearnedSettings(network="none"),
    )
    timing = prepare(base).timing  # bad input is refused here, not in a worker
    base = replace(base, duration_s=fleet.duration_s or timing.in_periods(own(fleet, "duration_s")))
    paths = [folder / f"flight_{i:04d}.npz" for i in range(fleet.flights)]
    missing = [i for i, path in enumerate(paths) if not path.exists()]
    jobs = [(paths[i], starting_at(base, start_attitude(fleet.seed, i))) for i in missing]
    if jobs:
        _fly_all(jobs, min(workers, len(jobs)))
    return [read_telemetry(path) for path in paths]


def _fly_all(jobs: list[tuple[Path, FlightSettings]], workers: int) -> None:
    """Fly in fresh processes; after a failure or Ctrl-C no flight goes on."""
    with (
        tqdm(total=len(jobs), desc="flights", disable=None) as bar,
        contextlib.closing(run_all(local_pool(workers), _fly_job, jobs)) as results,
    ):
        for _, lost in results:
            if lost is not None:
                raise lost
            bar.update()


def _fly_job(job: tuple[Path, FlightSettings]) -> None:
    fly_one(*job)


def sixths(flights: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which flights train, are held out for early stopping (a sixth), and unseen (a sixth)."""
    sixth, index = flights // 6, np.arange(flights)
    return index[2 * sixth :], index[:sixth], index[sixth : 2 * sixth]


def fly_one(path: Path, settings: FlightSettings) -> None:
    """Fly once and write the telemetry."""
    mission = prepare(settings)
    flight = mission.fly()
    if flight.ending is not Ending.COMPLETE:
        raise OutputError(f"a training flight was broken off: {flight.reason}")
    plant = flight.plant
    torque = np.array(flight.commands)
    write_telemetry(path, Telemetry(plant.tick, plant.rates, plant.wheel_speeds, torque))


def starting_at(base: FlightSettings, q: Quaternion) -> FlightSettings:
    """The same flight from another attitude relative to the target."""
    turn = attitude.rotation_vector(q)
    angle = float(np.linalg.norm(turn))
    x, y, z = (turn / angle).tolist()
    return replace(base, axis=(x, y, z), angle_deg=math.degrees(angle))


def start_attitude(seed: int, index: int) -> Quaternion:
    """The attitude in which a training flight starts, relative to the target: uniform among those
    at least 5 degrees from every attitude of the campaign and from the target itself."""
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    avoided = _campaign()
    while True:
        q = attitude.normalized(random.standard_normal(4))
        if attitude.error_angle(q, avoided).min() > CLEARANCE:
            return q


def _campaign() -> Quaternion:
    chosen = choose_attitudes("paper")
    axes = np.array([start.axis for start in chosen])
    angles = np.radians([start.angle_deg for start in chosen])
    return np.concatenate([attitude.from_axis_angle(axes, angles), attitude.IDENTITY[None]])
