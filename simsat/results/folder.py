"""A run's folder: made once, never overwritten, and filled with what the README lists."""

import hashlib
import importlib.metadata
import json
import platform
import subprocess
from datetime import datetime
from pathlib import Path
from typing import Any

from simsat.control.ground.errors import OutputError
from simsat.mjcf.shipped import find_model
from simsat.settings import as_json

RUNS = Path("runs")
PACKAGES = ("simsat", "mujoco", "casadi", "numpy", "scipy", "torch", "rerun-sdk")


def make_folder(out: Path | None, name: str) -> Path:
    """The folder to write into, created; `name` labels a default one under runs/.

    Raises `OutputError` if it exists already or can't be written.
    """
    folder = out if out is not None else _fresh(RUNS / f"{datetime.now():%Y-%m-%d-%H%M%S}-{name}")
    try:
        if folder.exists():
            raise OutputError(f"--out '{folder}' exists already; name a new folder")
        folder.mkdir(parents=True)
    except OSError as error:
        raise OutputError(f"can't write the folder '{folder}': {error.strerror}") from error
    return folder


def _fresh(folder: Path) -> Path:
    """The folder's name, numbered if several runs start within one second."""
    candidate, number = folder, 2
    while candidate.exists():
        candidate = folder.with_name(f"{folder.name}-{number}")
        number += 1
    return candidate


def write_settings(folder: Path, mission_settings: Any, model: Path) -> None:
    """settings.json: all settings, versions, the model file's hash, the git revision if any."""
    path = find_model(model)
    record = {
        "settings": as_json(mission_settings),
        "model_file": str(path),
        "model_sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "versions": {name: _version(name) for name in PACKAGES},
        "python": platform.python_version(),
        "git_revision": _revision(),
    }
    write_json(folder / "settings.json", record)


def write_json(path: Path, record: Any) -> None:
    """Indented JSON, by way of a temporary file: the path never holds half a record."""
    part = path.with_suffix(".part")
    part.write_text(json.dumps(record, indent=2, allow_nan=False) + "\n")
    part.replace(path)


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _revision() -> str | None:
    """The revision of the checkout that this code was imported from."""
    here = Path(__file__).resolve().parent
    try:
        answer = subprocess.run(
            ["git", "rev-parse", "HEAD"], cwd=here, capture_output=True, text=True, check=False
        )
    except OSError:
        return None
    return answer.stdout.strip() or None
