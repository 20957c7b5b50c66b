"""What a campaign's folder carries: the spacecraft and networks of its points.

So that its rows can be flown again elsewhere, whatever becomes of the originals. `carried/` is
written whole or not at all; `places.json` in it says where the files of each point lie.
"""

import shutil
from pathlib import Path

from simsat.campaign.run import CampaignRun
from simsat.campaign.study import label
from simsat.mjcf import read_model
from simsat.mjcf.shipped import find_model
from simsat.results.copies import carry
from simsat.results.files import PART, write_json
from simsat.results.saved import read_json

CARRIED = "carried"
PLACES = "places.json"

Places = dict[str, dict[str, str]]
"""By the point's label: where the file of each setting lies, relative to the folder."""


def carry_points(folder: Path, runs: tuple[CampaignRun, ...]) -> None:
    """Copy what the campaign flies with into its folder, in the place of earlier copies.

    Raises `OutputError` on a file that can't be copied.
    """
    new = folder / (CARRIED + PART)
    shutil.rmtree(new, ignore_errors=True)
    copied = dict[tuple[str, ...], dict[str, str]]()
    places: Places = {}
    for run in {label(run.point): run for run in runs}.values():
        s = run.settings
        files = (str(s.model), s.network, s.learned.network)
        if files not in copied:
            there = new / str(len(copied))
            there.mkdir(parents=True)
            found = carry(there, s, read_model(find_model(s.model)))
            prefix = f"{CARRIED}/{len(copied)}"
            copied[files] = {name: f"{prefix}/{place}" for name, place in found.items()}
        places[label(run.point)] = copied[files]
    write_json(new / PLACES, places)
    shutil.rmtree(folder / CARRIED, ignore_errors=True)
    new.rename(folder / CARRIED)


def places_in(folder: Path) -> Places:
    """Where the files lie; empty for a folder that carries none. Raises `OutputError` if that
    can't be read."""
    path = folder / CARRIED / PLACES
    return read_json(path) if path.exists() else {}
