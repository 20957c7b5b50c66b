"""Where the spacecraft is, kept outside MuJoCo: an orbit as everyone asks it, and a circular one.

The circular one is r(t) = R (cos a P + sin a Q), a = u0 + n t, n = sqrt(mu / R^3), with P the
direction of the ascending node and Q 90 degrees ahead of it in the orbit's plane. (Orbital
coordinates in a MuJoCo free joint cost 1.8e-3 degrees of attitude to round-off; the attitude needs
the orbit only through its torques.)
"""

import math
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated, Protocol

from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import Bounds, Settings
from simsat.environment import earth
from simsat.environment.components import Number, Triple, combined, cos_sin, cross, scaled

ALTITUDE_MIN_KM, ALTITUDE_MAX_KM = 150.0, 300_000.0
"""Below, free-molecular flow and a circular orbit end; above, the Moon is near."""


class Centre(Enum):
    """What a spacecraft goes around."""

    EARTH = "the Earth"
    SUN = "the Sun"


@dataclass(frozen=True)
class OrbitSettings(Settings, group="orbit"):
    """A circular orbit around the Earth unless told otherwise, or elements from a file."""

    altitude_km: Annotated[float, Bounds(ALTITUDE_MIN_KM, ALTITUDE_MAX_KM)] = 500.0
    """Height above the equatorial radius, km, 150 to 300000: lower means more drag, above 2000
    there is none; 35786 is geostationary."""
    inclination_deg: float = 97.4
    """Angle between orbit plane and equator, degrees: 97.4 is Sun-synchronous at 500 km."""
    raan_deg: float = 40.0
    """Right ascension of the ascending node, degrees: turns the orbit's plane about the pole."""
    arg_latitude_deg: float = 25.0
    """Angle from the ascending node to the spacecraft at t = 0, degrees."""
    sun_distance_au: Annotated[float, Bounds(0.1, 10.0)] | None = None
    """Distance from the Sun, astronomical units, of a spacecraft that goes around the Sun, in the
    ecliptic and on the Earth's side at t = 0; altitude and angles mean nothing then. Only sunlight
    acts out there."""
    epoch_utc: str = "2026-03-20T12:00:00"
    """Date and time at t = 0, UTC: places the Sun and the Earth's rotation below the orbit."""
    tle: Path | None = None
    """Orbit from a file in place of the figures above but the epoch: two-line elements, or an orbit
    mean-elements message (OMM) as XML, CSV or JSON, flown by SGP4."""

    def check(self) -> None:
        """The epoch is a date, and there is one orbit."""
        earth.days_since_j2000(self.epoch_utc)
        if self.tle is not None and self.sun_distance_au is not None:
            raise SettingsError(
                "--orbit.tle is an orbit around the Earth, --orbit.sun-distance-au one around the "
                "Sun: give one of them"
            )


class Orbit(Protocol):
    """An orbit, ready to evaluate at any time t (s, a float or an array)."""

    @property
    def epoch_days(self) -> float:
        """Days from J2000 to t = 0."""
        ...

    @property
    def period(self) -> float:
        """Time of one revolution, s."""
        ...

    @property
    def centre(self) -> Centre:
        """What it goes around."""
        ...

    def direction(self, t: Number) -> Triple:
        """Unit vector from that centre to the spacecraft, inertial axes."""
        ...

    def velocity_direction(self, t: Number) -> Triple:
        """Unit vector along the inertial velocity, inertial axes."""
        ...

    def radius_at(self, t: Number) -> Number:
        """Distance from that centre, m."""
        ...

    def speed_at(self, t: Number) -> Number:
        """Inertial speed, m/s."""
        ...

    def position(self, t: Number) -> Triple:
        """Position, m, inertial axes."""
        ...

    def velocity(self, t: Number) -> Triple:
        """Velocity, m/s, inertial axes."""
        ...


@dataclass(frozen=True)
class CircularOrbit:
    """A circular orbit."""

    radius: float
    """R, m."""
    rate: float
    """n, rad/s."""
    phase: float
    """u0, rad."""
    P_N: Triple
    Q_N: Triple
    epoch_days: float
    """Days from J2000 to t = 0."""
    centre: Centre = Centre.EARTH

    def direction(self, t: Number) -> Triple:
        """Unit vector from the centre of what it goes around to the spacecraft, inertial axes."""
        c, s = cos_sin(self.phase + self.rate * t)
        return combined(c, self.P_N, s, self.Q_N)

    def velocity_direction(self, t: Number) -> Triple:
        """Unit vector along the inertial velocity, inertial axes."""
        c, s = cos_sin(self.phase + self.rate * t)
        return combined(-s, self.P_N, c, self.Q_N)

    def radius_at(self, t: Number) -> float:
        """R, m, at any time."""
        return self.radius

    def speed_at(self, t: Number) -> float:
        """R n, m/s, at any time."""
        return self.radius * self.rate

    def position(self, t: Number) -> Triple:
        """Position from that centre, m, inertial axes."""
        return scaled(self.radius, self.direction(t))

    def velocity(self, t: Number) -> Triple:
        """Velocity, m/s, inertial axes."""
        return scaled(self.radius * self.rate, self.velocity_direction(t))

    @property
    def period(self) -> float:
        """Time of one revolution, s."""
        return 2.0 * math.pi / self.rate


def circular_orbit(settings: OrbitSettings) -> CircularOrbit:
    """The circular orbit that the settings describe."""
    if settings.sun_distance_au is not None:
        return _around_the_sun(settings.sun_distance_au, settings.epoch_utc)
    radius = earth.RADIUS + 1e3 * settings.altitude_km
    node, tilt = math.radians(settings.raan_deg), math.radians(settings.inclination_deg)
    return CircularOrbit(
        radius=radius,
        rate=math.sqrt(earth.MU / radius**3),
        phase=math.radians(settings.arg_latitude_deg),
        P_N=(math.cos(node), math.sin(node), 0.0),
        Q_N=(
            -math.sin(node) * math.cos(tilt),
            math.cos(node) * math.cos(tilt),
            math.sin(tilt),
        ),
        epoch_days=earth.days_since_j2000(settings.epoch_utc),
    )


def _around_the_sun(distance_au: float, epoch_utc: str) -> CircularOrbit:
    days = earth.days_since_j2000(epoch_utc)
    radius = distance_au * earth.AU
    outwards = scaled(-1.0, earth.sun_direction(days))
    return CircularOrbit(
        radius=radius,
        rate=math.sqrt(earth.MU_SUN / radius**3),
        phase=0.0,
        P_N=outwards,
        Q_N=cross(earth.ecliptic_pole(days), outwards),
        epoch_days=days,
        centre=Centre.SUN,
    )
