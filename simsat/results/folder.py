"""A run's folder: made once, never overwritten, and filled with what the README lists."""

import errno
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from simsat.control.ground.errors import OutputError
from simsat.identity.code import version
from simsat.identity.flight import Identity
from simsat.results.files import write_json
from simsat.settings import as_json

RUNS = Path("runs")
SETTINGS = "settings.json"
RECORDING = "recording.rrd"
METRICS = "metrics.json"
SERIES = "timeseries.parquet"
STEPS = "steps.parquet"
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # disk, quota, largest file allowed
PACKAGES = (
    "simsat", "mujoco", "casadi", "numpy", "scipy", "torch", "pymsis", "ppigrf", "sgp4",
    "rerun-sdk", "pyarrow", "matplotlib", "safetensors", "tyro",
)  # fmt: skip


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


def write_settings(
    folder: Path,
    settings: Any,
    flown_with: Identity,
    copies: Mapping[str, str] | None = None,
    came_to: Mapping[str, float | None] | None = None,
) -> None:
    """settings.json: all settings as they were given, what those in the craft's own units came to
    in SI, what the results depend on besides, installed versions, and where in the folder the files
    lie that it carries (see `copies`)."""
    record = {
        "settings": as_json(settings),
        "came_to": dict(came_to or {}),
        "flown_with": flown_with,
        "versions": {name: version(name) for name in PACKAGES},
        "copies": dict(copies or {}),
    }
    write_json(folder / SETTINGS, record)
