"""What a run's folder carries besides its results: the spacecraft and the networks it flew with.

`model/` holds the MJCF with all it includes, `networks/` the files of the networks, `files/` what
else was read (orbit elements, a reference). So the flight can be flown again elsewhere, whatever
becomes of the originals.
"""

import contextlib
import shutil
from pathlib import Path
from typing import Any

from simsat.control.ground.errors import NetworkError, OutputError
from simsat.control.ground.settings import changed
from simsat.flight.plugins import is_plugin
from simsat.mjcf import Model
from simsat.mjcf.shipped import find_model
from simsat.mjcf.travel import copy_model
from simsat.networks.appendage import find_appendage
from simsat.networks.correction import find_network
from simsat.settings import FlightSettings

MODEL = "model"
NETWORKS = "networks"
FILES = "files"
SHIPPED = "network"  # beside a model


def carry(folder: Path, settings: FlightSettings, model: Model) -> dict[str, str]:
    """Copy what a flight flies with into the folder; returns the places by setting, relative to it.
    A network from beside the model goes beside its copy. Raises `OutputError`."""
    try:
        original = find_model(settings.model)
        copied = {"model": copy_model(model, original, folder / MODEL)}
        for name, file in _networks(settings).items():
            beside = file.parent == original.parent / SHIPPED
            place = copied["model"].parent / SHIPPED if beside else folder / NETWORKS
            place.mkdir(exist_ok=True)
            shutil.copyfile(file, place / file.name)
            if not beside:
                copied[name] = place / file.name
        for name, file in settings.files.items():
            place = folder / FILES / name
            place.mkdir(parents=True)
            copied[name] = Path(shutil.copyfile(file, place / file.name))
    except OSError as error:
        raise OutputError(f"can't copy the spacecraft into '{folder}': {error}") from error
    return {name: path.relative_to(folder).as_posix() for name, path in copied.items()}


def _networks(settings: FlightSettings) -> dict[str, Path]:
    """Files of the networks that the settings name, whether the controller asks them or not: they
    are part of the flight's identity."""
    found = dict[str, Path]()
    if not is_plugin(settings.network):
        with contextlib.suppress(NetworkError):  # a controller that needs one says so
            found["network"] = find_network(settings.network, settings.model)
    with contextlib.suppress(NetworkError):
        path = find_appendage(settings.learned.network, settings.model)
        if path is not None:
            found["learned.network"] = path
    return found


def copies_in(record: dict[str, Any]) -> dict[str, str]:
    """The places that a folder's settings.json states; none in a damaged one."""
    copies = record.get("copies")
    return copies if isinstance(copies, dict) else {}


def with_copies(settings: FlightSettings, folder: Path, places: dict[str, str]) -> FlightSettings:
    """The settings, flying what the folder carries in the place of the originals."""
    return changed(settings, {name: _as_setting(name, folder / place)
                              for name, place in places.items()})  # fmt: skip


def _as_setting(name: str, path: Path) -> Path | str | tuple[str]:
    """Networks are named by a text, references by a list of words, all else by a path."""
    if name == "reference.to":
        return (str(path),)
    return str(path) if name.endswith("network") else path
