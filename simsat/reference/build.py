"""From settings to the reference that a flight is to follow."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from simsat.control.ground.arrays import Quaternion
from simsat.control.ground.errors import SettingsError
from simsat.control.reference.reference import Curve, Inertial, Reference
from simsat.environment.orbit import Orbit
from simsat.reference.aem import read_aem
from simsat.reference.pointing import (
    STATION_STEP_S,
    STEP_S,
    Directions,
    pointing,
    refuse_unseen,
    to_nadir,
    to_station,
    to_sun,
)
from simsat.reference.settings import KNOWN, ReferenceSettings
from simsat.reference.tables import read_table

ALONG_ORBIT: dict[str, Callable[[Orbit], Directions]] = {"nadir": to_nadir, "sun": to_sun}


def build_reference(
    settings: ReferenceSettings, target: Quaternion, orbit: Orbit, epoch_utc: str, duration: float
) -> Reference:
    """What the settings say is followed for so many seconds; `target` is the inertial attitude.

    Raises `SettingsError` in one sentence.
    """
    word, *rest = settings.to
    if word == "station":
        return _station(settings, rest, orbit, duration)
    if rest:
        raise SettingsError(f"--reference {word} takes nothing more, not {' '.join(rest)}")
    if word == "inertial":
        return Inertial(target)
    if word in ALONG_ORBIT:
        return _pointing(settings, ALONG_ORBIT[word](orbit), duration, STEP_S)
    path = Path(word)
    if path.suffix.lower() == ".csv":
        return read_table(path, duration)
    if path.suffix.lower() in (".aem", ".kvn", ".txt"):
        return read_aem(path, epoch_utc, duration)
    raise SettingsError(
        f"--reference '{word}' is none of {', '.join(KNOWN)} and no file that ends in .csv, .aem, "
        ".kvn or .txt"
    )


def _station(settings: ReferenceSettings, words: list[str], orbit: Orbit, duration: float) -> Curve:
    try:
        latitude, longitude = (float(word) for word in words)
    except ValueError:
        latitude = longitude = np.nan
    if not (-90.0 <= latitude <= 90.0 and -360.0 <= longitude <= 360.0):
        raise SettingsError(
            f"--reference station {' '.join(words)}: give latitude (-90 to 90) and longitude (-360 "
            "to 360) in degrees"
        )
    refuse_unseen(orbit, latitude, longitude, duration)
    return _pointing(settings, to_station(orbit, latitude, longitude), duration, STATION_STEP_S)


def _pointing(
    settings: ReferenceSettings, directions: Directions, duration: float, step: float
) -> Curve:
    boresight, second = np.array(settings.boresight), np.array(settings.second)
    return pointing(directions, boresight, second, duration, step)
