"""An orbit from mean elements, a TLE or an OMM, flown by SGP4.

SGP4 answers in TEME: the true equator and mean equinox of date, which is this project's inertial
frame but for nutation (17 arcseconds at most). Source: Vallado et al., Revisiting Spacetrack Report
3, AIAA 2006-6753, through `sgp4`.
"""

import io
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import DivergedError, SettingsError
from simsat.environment import earth
from simsat.environment.components import Number, Triple, dot, scaled
from simsat.environment.orbit import ALTITUDE_MIN_KM, Centre
from simsat.environment.table import Table

STEP_S = 30.0  # between samples: cubic between them is within 0.1 m
OLD_DAYS = 14.0
"""Elements further from the epoch are refused: they are off by 1 to 3 km a day in low orbits."""
DAY_S = 86400.0
J2000_JD = 2451545.0
TLE_LINE = 69  # characters


@dataclass(frozen=True)
class TabulatedOrbit:
    """An orbit between samples of position and velocity."""

    table: Table
    """t (s) -> position (m) and velocity (m/s), inertial axes."""
    epoch_days: float
    period: float
    centre: Centre = Centre.EARTH

    def position(self, t: Number) -> Triple:
        """Position, m, inertial axes."""
        x, y, z = self.table(t)[:3]
        return x, y, z

    def velocity(self, t: Number) -> Triple:
        """Velocity, m/s, inertial axes."""
        x, y, z = self.table(t)[3:]
        return x, y, z

    def direction(self, t: Number) -> Triple:
        """Unit vector from the Earth's centre to the spacecraft, inertial axes."""
        return _unit(self.position(t))

    def velocity_direction(self, t: Number) -> Triple:
        """Unit vector along the inertial velocity, inertial axes."""
        return _unit(self.velocity(t))

    def radius_at(self, t: Number) -> Number:
        """Distance from the Earth's centre, m."""
        return _length(self.position(t))

    def speed_at(self, t: Number) -> Number:
        """Inertial speed, m/s."""
        return _length(self.velocity(t))


def _length(a: Triple) -> Number:
    square = dot(a, a)
    return math.sqrt(square) if isinstance(square, float) else np.sqrt(square)


def _unit(a: Triple) -> Triple:
    return scaled(1.0 / _length(a), a)


def read_orbit(path: Path, epoch_utc: str) -> TabulatedOrbit:
    """The orbit of the elements in a file, t = 0 at the epoch.

    Raises `SettingsError` in one sentence on a file that holds no elements or several, a checksum
    that doesn't fit, elements too far from the epoch, or an orbit that has decayed.
    """
    from sgp4.api import SGP4_ERRORS  # only this model needs it

    satellite = _satellite(path)
    days = earth.days_since_j2000(epoch_utc)
    age = days - (satellite.jdsatepoch - J2000_JD + satellite.jdsatepochF)
    if abs(age) > OLD_DAYS:
        raise SettingsError(
            f"--orbit.tle '{path}': its elements are {abs(age):.1f} days "
            f"{'older' if age > 0.0 else 'younger'} than --orbit.epoch-utc {epoch_utc}, they are "
            f"good for {OLD_DAYS:g}"
        )
    code, r, _ = satellite.sgp4(J2000_JD + days, 0.0)
    if code:
        raise SettingsError(f"--orbit.tle '{path}': {SGP4_ERRORS[code]}")
    altitude_km = math.hypot(*r) - earth.RADIUS / 1e3
    if not altitude_km >= ALTITUDE_MIN_KM:
        raise SettingsError(
            f"--orbit.tle '{path}': {altitude_km:.0f} km high at t = 0, {ALTITUDE_MIN_KM:g} km are "
            "the least"
        )

    def sample(t: Array) -> Array:
        fraction = days % 1.0 + t / DAY_S
        codes, position, velocity = satellite.sgp4_array(
            np.full(len(t), J2000_JD + math.floor(days)), fraction
        )
        if codes.any():
            k = int(np.flatnonzero(codes)[0])
            raise DivergedError(f"the orbit ended at t = {t[k]:.0f} s: {SGP4_ERRORS[codes[k]]}")
        return 1e3 * np.concatenate([position, velocity], axis=1)

    period = 2.0 * math.pi / satellite.no_kozai * 60.0  # no_kozai in rad/min
    return TabulatedOrbit(Table(sample, STEP_S), days, period)


def _satellite(path: Path) -> Any:
    try:
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"--orbit.tle '{path}' can't be read: {error}") from error
    try:
        return _two_lines(text) if path.suffix not in OMM else _mean_elements(text, path.suffix)
    except (ValueError, KeyError, TypeError, AttributeError, SyntaxError) as error:
        raise SettingsError(f"--orbit.tle '{path}': {_told(error)}") from error


def _told(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"the message has no {error}"
    return f"no elements could be read ({error})"


def _two_lines(text: str) -> Any:
    from sgp4.api import WGS72, Satrec
    from sgp4.io import verify_checksum

    lines = [line.rstrip() for line in text.splitlines() if line[:2] in ("1 ", "2 ")]
    if [line[0] for line in lines] != ["1", "2"]:
        raise ValueError(f"{len(lines)} lines of elements where one pair is wanted, 1 .. and 2 ..")
    if any(len(line) != TLE_LINE for line in lines):
        raise ValueError(f"a line of elements has {TLE_LINE} characters")
    verify_checksum(*lines)
    return Satrec.twoline2rv(*lines, WGS72)


def _mean_elements(text: str, suffix: str) -> Any:
    from sgp4 import omm
    from sgp4.api import Satrec

    messages = OMM[suffix](text)
    if len(messages) != 1:
        raise ValueError(f"{len(messages)} messages where one is wanted")
    fields = {str(name): str(value) for name, value in messages[0].items()}
    frame = fields.get("REF_FRAME", "TEME")
    if frame != "TEME" or fields.get("MEAN_ELEMENT_THEORY", "SGP4") not in ("SGP4", "SGP/SGP4"):
        raise ValueError(f"mean elements of SGP4 in TEME are wanted, not in {frame}")
    if "." not in fields["EPOCH"]:  # the reader wants a fraction
        fields["EPOCH"] += ".0"
    satellite = Satrec()
    omm.initialize(satellite, fields)
    return satellite


def _from_xml(text: str) -> list[Mapping[str, Any]]:
    from sgp4 import omm

    return list(omm.parse_xml(io.StringIO(text)))


def _from_csv(text: str) -> list[Mapping[str, Any]]:
    from sgp4 import omm

    return list(omm.parse_csv(io.StringIO(text)))


def _from_json(text: str) -> list[Mapping[str, Any]]:
    content = json.loads(text)
    return content if isinstance(content, list) else [content]


OMM: Mapping[str, Callable[[str], list[Mapping[str, Any]]]] = {
    ".xml": _from_xml,
    ".csv": _from_csv,
    ".json": _from_json,
}
"""Readers of mean-elements messages by the file's ending; every other file holds two lines."""
