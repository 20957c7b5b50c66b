"""Fly training flights and keep their telemetry: python -m learning.data --help."""

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from simsat.campaign.lock import locked
from simsat.command import command, parse
from simsat.control.ground.settings import Count, Settings
from simsat.mjcf import read_model
from simsat.mjcf.shipped import find_model

from .correction.data import FleetSettings, fly_fleet
from .files import claim_folder


@dataclass(frozen=True)
class DataSettings(Settings):
    """Fly training flights under the baseline and keep their telemetry at 20 Hz."""

    fleet: Annotated[FleetSettings, tyro.conf.arg(name="")] = field(default_factory=FleetSettings)
    out: Path = Path("runs/training-data")
    """Folder to write; if an interrupted call with the same settings left it, it is completed."""
    workers: Count = 2
    """Processes to fly in; the result doesn't depend on it."""


def main() -> int:
    """The command line."""
    settings = parse(DataSettings, __doc__)
    fleet = settings.fleet
    read_model(find_model(fleet.model))  # refused before a folder is claimed for it
    claim_folder(settings.out, fleet)
    with locked(settings.out):
        flights = fly_fleet(settings.out, fleet, settings.workers)
    rows = sum(len(flight.omega) for flight in flights)
    print(f"{len(flights)} flights, {rows} samples in {settings.out}")
    return 0


if __name__ == "__main__":
    sys.exit(command(main))
