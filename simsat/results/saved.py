"""Reading back what a run left: its settings as they were given."""

import json
from pathlib import Path
from typing import Any, TypeVar

from simsat.control.ground.errors import OutputError, SettingsError
from simsat.control.ground.settings import Settings, built
from simsat.settings import as_json

Kind = TypeVar("Kind", bound=Settings)


def read_json(path: Path) -> dict[str, Any]:
    """A JSON file that holds an object. Raises `OutputError` that names it."""
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError) as error:
        raise OutputError(f"can't read '{path}': {error}") from error
    if not isinstance(content, dict):
        raise OutputError(f"'{path}' holds no object but {type(content).__name__}")
    return content


def settings_from_json(kind: type[Kind], saved: Any, where: Path) -> Kind:
    """The settings that `as_json` made plain.

    Raises `OutputError` that names the file and the setting that isn't one or doesn't fit.
    """
    try:
        settings = built(kind, saved)
    except SettingsError as error:
        raise OutputError(f"'{where}' holds no {kind.__name__} of this version: {error}") from error
    missing = _missing(as_json(settings), saved)
    if missing:
        raise OutputError(
            f"'{where}' holds no {kind.__name__} of this version: no {', '.join(missing)}"
        )
    return settings


def _missing(whole: dict[str, Any], saved: dict[str, Any], prefix: str = "") -> list[str]:
    """Dotted names of the settings that are not there."""
    names: list[str] = []
    for name, value in whole.items():
        if name not in saved:
            names.append(prefix + name)
        elif isinstance(value, dict):
            names += _missing(value, saved[name], f"{prefix}{name}.")
    return names
