"""Files of data and training: written whole or not at all, and claimed by their settings."""

import io
import json
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from simsat.control.ground.errors import OutputError
from simsat.identity.difference import differences
from simsat.results.files import PART, write_bytes, write_json
from simsat.results.folder import SETTINGS
from simsat.settings import as_json

from .correction.windows import Telemetry
from .identity import training_identity

TRAINED_WITH = "trained_with"


def claim_folder(folder: Path, settings: Any) -> bool:
    """Make a folder for these settings; True if an earlier call with the same ones left it.

    Raises `OutputError` if it holds something else, was begun with another model, code or package,
    or can't be written.
    """
    wanted, identity = as_json(settings), training_identity(settings.model)
    note = folder / SETTINGS
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"--out '{folder}' is a file; name a folder")
    if not folder.exists() or _is_unclaimed(folder):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            write_json(note, wanted | {TRAINED_WITH: identity})
        except OSError as error:
            raise OutputError(f"can't write the folder '{folder}': {error.strerror}") from error
        return False
    if not note.is_file():
        raise OutputError(f"--out '{folder}' exists already and is not a training's; name another")
    try:
        found = json.loads(note.read_text())
    except (OSError, ValueError) as error:
        raise OutputError(f"can't read '{note}' ({error}); name another --out") from error
    if not isinstance(found, dict):
        raise OutputError(f"'{note}' holds something else; name another --out")
    differing = sorted(name for name in wanted if found.get(name) != wanted[name])
    if differing:
        flags = ", ".join(f"--{name.replace('_', '-')}" for name in differing)
        raise OutputError(f"--out '{folder}' was begun with other settings ({flags}); name another")
    changed = differences(found.get(TRAINED_WITH) or {}, identity)
    if changed:
        raise OutputError(
            f"--out '{folder}' was begun otherwise ({'; '.join(changed)}); name another"
        )
    return True


def _is_unclaimed(folder: Path) -> bool:
    """Whether it holds nothing but what a kill leaves before the folder says what it is for."""
    return {path.name for path in folder.iterdir()} <= {SETTINGS + PART}


def write_telemetry(path: Path, flight: Telemetry) -> None:
    """Write a flight's telemetry as npz."""
    buffer = io.BytesIO()
    np.savez(
        buffer,
        sample=np.array(flight.sample),
        omega=flight.omega,
        wheel_speed=flight.wheel_speed,
        torque=flight.torque,
    )
    write_bytes(path, buffer.getvalue())


def read_telemetry(path: Path) -> Telemetry:
    """Read it back. Raises `OutputError` on a file that is not telemetry."""
    try:
        with np.load(path) as content:
            return Telemetry(
                float(content["sample"]),
                content["omega"],
                content["wheel_speed"],
                content["torque"],
            )
    except (OSError, KeyError, ValueError, BadZipFile) as error:
        raise OutputError(
            f"'{path}' is not the telemetry of a training flight: delete it and run again"
        ) from error
