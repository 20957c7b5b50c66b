"""The settings of a flight from where they were kept: a run's folder, or a file of one's own."""

import sys
import tomllib
from pathlib import Path
from typing import Any

from simsat.control.ground.errors import OutputError, SettingsError
from simsat.control.ground.settings import built
from simsat.identity.difference import differences
from simsat.identity.flight import expected_identity
from simsat.results.copies import copies_in, with_copies
from simsat.results.folder import SETTINGS
from simsat.results.saved import read_json, settings_from_json
from simsat.settings import FlightSettings


def read_flight(source: Path) -> FlightSettings:
    """The settings that a run's folder or a settings file (TOML, JSON) holds.

    A folder is flown with the spacecraft and networks that it carries; what is not as it was then
    (code, packages, an edited copy) is said on stderr. Raises `SettingsError` or `OutputError`.
    """
    if source.is_dir():
        return _from_folder(source)
    try:
        values = _read(source)
        return built(FlightSettings, values)
    except SettingsError as error:
        raise SettingsError(f"--from '{source}': {error}") from error


def _from_folder(folder: Path) -> FlightSettings:
    record = read_json(folder / SETTINGS)
    settings = settings_from_json(FlightSettings, record.get("settings"), folder / SETTINGS)
    settings = with_copies(settings, folder, copies_in(record))
    for phrase in differences(record.get("flown_with") or {}, expected_identity(settings)):
        print(f"not as it was: {phrase}", file=sys.stderr)
    return settings


def _read(path: Path) -> Any:
    if path.suffix == ".json":
        try:
            content = read_json(path)
        except OutputError as error:
            raise SettingsError(str(error)) from error
        return content.get("settings", content)  # a run's own settings.json serves as well
    try:
        return tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise SettingsError(f"there is no such folder or file ({error.strerror})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"it is no TOML: {error}") from error
