"""A campaign's folder: made once, and resumed only by the same campaign.

`campaign.json` holds what decides the numbers: flight settings, controllers, attitudes, the study's
points, the hashes of model and network files, and the versions of the packages that compute.
`settings.json` says how it was started, as in any run.
"""

import contextlib
import hashlib
import importlib.metadata
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from simsat.campaign.attitudes import InitialRotation
from simsat.campaign.run import CampaignRun
from simsat.campaign.study import Point
from simsat.control.ground.errors import NetworkError, OutputError
from simsat.mjcf.shipped import find_model
from simsat.networks.appendage import find_appendage
from simsat.networks.correction import find_network
from simsat.results.folder import make_folder, write_json, write_settings
from simsat.settings import CommonSettings, as_json

IDENTITY = "campaign.json"
COMPUTING = ("mujoco", "casadi", "numpy", "scipy")


def identity(
    common: CommonSettings,
    controllers: tuple[str, ...],
    starts: tuple[InitialRotation, ...],
    points: tuple[Point, ...],
    runs: tuple[CampaignRun, ...],
) -> dict[str, Any]:
    """What makes two campaigns the same, as plain JSON."""
    return {
        "controllers": list(controllers),
        "attitudes": as_json([asdict(start) for start in starts]),
        "study": as_json(points),
        "flight": as_json(common),
        "sha256": _hashes(runs),
        "versions": {name: importlib.metadata.version(name) for name in COMPUTING},
    }


def _hashes(runs: tuple[CampaignRun, ...]) -> dict[str, str]:
    """Of every file that the runs fly with."""
    files = {find_model(run.settings.model) for run in runs}
    for network, model in {(run.settings.network, run.settings.model) for run in runs}:
        with contextlib.suppress(NetworkError):  # none: a controller that needs it says so
            files.add(find_network(network, model))
    for spec, model in {(run.settings.learned.network, run.settings.model) for run in runs}:
        with contextlib.suppress(NetworkError):
            appendage = find_appendage(spec, model)
            files |= set() if appendage is None else {appendage}
    return {str(file): hashlib.sha256(file.read_bytes()).hexdigest() for file in sorted(files)}


def open_folder(out: Path | None, resume: bool, mine: dict[str, Any], settings: Any) -> Path:
    """A new folder, or with `resume` the one that this very campaign began.

    Raises `OutputError` if it exists, or if another campaign made it, saying which setting differs.
    """
    if out is None or not resume or not out.exists():
        return _begin(make_folder(out, "campaign"), mine, settings)
    if (out / IDENTITY).exists():
        _refuse_other(out, mine)
        return out
    if not out.is_dir() or not _only_begun(out):
        raise OutputError(f"'{out}' is no campaign's folder: it has no {IDENTITY}")
    return _begin(out, mine, settings)


def _begin(folder: Path, mine: dict[str, Any], settings: Any) -> Path:
    """Say in the folder what it is for."""
    write_settings(folder, settings, settings.common.model)
    write_json(folder / IDENTITY, mine)
    return folder


def _only_begun(folder: Path) -> bool:
    """Whether a kill left nothing but what `_begin` writes before the campaign's identity."""
    names = {path.name for path in folder.iterdir()}
    return names <= {"settings.json", "settings.part", "campaign.part"}


def _refuse_other(folder: Path, mine: dict[str, Any]) -> None:
    try:
        theirs = json.loads((folder / IDENTITY).read_text())
    except (OSError, ValueError) as error:
        raise OutputError(
            f"can't read '{folder / IDENTITY}' ({error}); choose a new --out"
        ) from error
    if not isinstance(theirs, dict):
        raise OutputError(f"'{folder / IDENTITY}' is no campaign's; choose a new --out")
    differing = _differences(theirs, mine)
    if differing:
        raise OutputError(
            f"'{folder}' was made with other settings ({'; '.join(differing)}); "
            "resume with its own, or choose a new --out"
        )


def _differences(theirs: Any, mine: Any, name: str = "") -> list[str]:
    """One phrase for each value that differs, named as on the command line."""
    if isinstance(theirs, dict) and isinstance(mine, dict):
        phrases = []
        for key in dict.fromkeys([*theirs, *mine]):
            inner = f"{name}.{key}" if name else key
            phrases += _differences(theirs.get(key), mine.get(key), inner)
        return phrases
    if theirs == mine:
        return []
    name = name.removeprefix("flight.")
    if isinstance(theirs, list) and name == "attitudes":
        return [f"attitudes: {len(theirs)} then, {len(mine)} now, or in other places"]
    return [f"{name} was {_short(theirs)}, now {_short(mine)}"]


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
