"""Reading back what a run left: its settings as they were given."""

import dataclasses
import json
import types
import typing
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar

from simsat.control.ground.errors import OutputError

Kind = TypeVar("Kind")


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
    """The settings that `as_json` made plain; what `saved` holds beyond them is left out.

    Raises `OutputError` that names the file and the setting which is missing or doesn't fit, and
    `SettingsError` for a value outside its range.
    """
    try:
        rebuilt: Kind = _rebuilt(kind, saved)
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise OutputError(f"'{where}' holds no {kind.__name__} of this version: {error}") from error
    return rebuilt


def _rebuilt(hint: Any, value: Any) -> Any:
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        hints = typing.get_type_hints(hint)
        return hint(**{f.name: _rebuilt(hints[f.name], value[f.name]) for f in _fields(hint)})
    origin = typing.get_origin(hint)
    if origin is tuple:
        return tuple(value)
    if origin in (typing.Union, types.UnionType):
        return None if value is None else _rebuilt(typing.get_args(hint)[0], value)
    if isinstance(hint, type) and issubclass(hint, (Path, Enum)):
        return hint(value)
    return value


def _fields(kind: Any) -> tuple[dataclasses.Field[Any], ...]:
    return dataclasses.fields(kind)
