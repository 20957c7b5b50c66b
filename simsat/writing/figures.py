"""What a spacecraft file is made from: a TOML file, with lists in it or in CSV files beside it."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from simsat.control.ground.arrays import Matrix3, Vector3
from simsat.control.ground.errors import ModelError, SettingsError
from simsat.control.ground.settings import NotNegative, Positive, Settings, built
from simsat.control.ground.units import units_for
from simsat.mjcf.refusals.timestep import LONGEST, SHORTEST, USUAL
from simsat.mjcf.wheels import RPM
from simsat.writing.bus import Body, joined, refuse_impossible
from simsat.writing.tables import read_rows, read_toml

Triple = tuple[float, float, float]
S = TypeVar("S", bound=Settings)

LISTS = ("part", "wheel")
_FLAG = re.compile(r"--(?:\w+\.)?([\w-]+)")
ROTOR_MOMENT = (
    0.6  # of the spin inertia, across the axis: a thin disc has 0.5, a short cylinder more
)


@dataclass(frozen=True)
class PartFigures(Settings, group="part"):
    """A line of a mass table."""

    mass: Positive
    """kg."""
    name: str = ""
    position: Triple = (0.0, 0.0, 0.0)
    """Of its centre of mass from the body's origin, m."""
    inertia: tuple[float, ...] = ()
    """About its own centre of mass, kg m^2: xx yy zz, or xx yy zz xy xz yz (products of inertia as
    they stand in the matrix, with their signs); none for a point."""


@dataclass(frozen=True)
class WheelFigures(Settings, group="wheel"):
    """A reaction wheel: its axis, two of spin inertia, momentum and speed, and its limits."""

    axis: Triple
    """Spin axis in body axes, of any length."""
    mass: Positive
    """Of the rotor, kg."""
    name: str = ""
    spin_inertia: Positive | None = None
    """kg m^2."""
    momentum: Positive | None = None
    """Most that it stores, Nms."""
    speed_rpm: Positive | None = None
    """Its limit, relative to the bus."""
    torque: Positive | None = None
    """Limit, Nm."""
    torque_envelope_rpm: tuple[NotNegative, ...] = ()
    """Pairs of speed (rpm) and driving torque (Nm) where it falls with speed."""
    torque_rate: Positive | None = None
    """Limit, Nm/s."""
    viscous: NotNegative = 0.0
    """Friction, Nms/rad."""
    coulomb: NotNegative = 0.0
    """Friction, Nm."""
    position: Triple = (0.0, 0.0, 0.0)
    """Of the rotor from the body's origin, m."""

    def check(self) -> None:
        """The axis has a direction; spin inertia and limits are known and agree."""
        if not np.linalg.norm(self.axis) > 0.0:
            raise SettingsError("axis is 0 0 0, which is no direction")
        known = (self.spin_inertia, self.momentum, self.speed_rpm)
        if self.spin_inertia is None and None in (self.momentum, self.speed_rpm):
            raise SettingsError("spin_inertia is missing: give it, or momentum and speed_rpm")
        if None not in known:
            raise SettingsError(
                "spin_inertia, momentum and speed_rpm are all given: leave one out, it "
                "follows from the others"
            )

    @property
    def Js(self) -> float:
        """Spin inertia, kg m^2."""
        if self.spin_inertia is not None:
            return self.spin_inertia
        assert self.momentum is not None
        assert self.speed_rpm is not None
        return self.momentum / (self.speed_rpm * RPM)

    @property
    def speed_limit_rpm(self) -> float | None:
        """None without a limit of speed or momentum."""
        if self.speed_rpm is None and self.momentum is not None:
            return self.momentum / self.Js / RPM
        return self.speed_rpm

    @property
    def direction(self) -> Vector3:
        """Unit vector of the axis."""
        axis = np.array(self.axis)
        unit: Vector3 = axis / np.linalg.norm(axis)
        return unit

    @property
    def moments(self) -> Vector3:
        """Principal moments of the rotor, the last about its axis, kg m^2."""
        return np.array([ROTOR_MOMENT, ROTOR_MOMENT, 1.0]) * self.Js

    @property
    def rotor(self) -> Body:
        """The rotor, round about its axis."""
        g, (across, _, spin) = self.direction, self.moments
        inertia = across * np.eye(3) + (spin - across) * np.outer(g, g)
        return Body(self.mass, np.array(self.position), inertia)


@dataclass(frozen=True)
class BoxFigures(Settings, group="box"):
    """The hull that drag and sunlight push on."""

    size: tuple[Positive, Positive, Positive]
    """Whole lengths along x, y, z, m."""
    position: Triple = (0.0, 0.0, 0.0)
    """Of its centre from the body's origin, m."""


@dataclass(frozen=True)
class WholeFigures(Settings):
    """The whole spacecraft, rotors included and locked."""

    name: str = ""
    mass: Positive | None = None
    """kg; not beside a mass table."""
    inertia: tuple[float, ...] = ()
    """About the centre of mass, kg m^2, as a part's; not beside a mass table."""
    centre_of_mass: Triple = (0.0, 0.0, 0.0)
    """From the body's origin, m; not beside a mass table."""
    timestep: Positive | None = None
    """Of the physics, s; default 0.01 or, where that does not suit the craft, what does."""
    nominal_inertia_factors: tuple[Positive, Positive, Positive] | None = None
    """What the controller is to believe of J's diagonal."""


@dataclass(frozen=True)
class Figures:
    """All that a file says, checked."""

    name: str
    whole: Body
    wheels: tuple[WheelFigures, ...]
    box: BoxFigures | None
    nominal_inertia_factors: Triple | None
    timestep: float


def read_figures(path: Path) -> Figures:
    """The figures in a TOML file.

    Raises `ModelError` naming the file, and the entry in it that is missing or wrong.
    """
    try:
        return _figures(read_toml(path), path)
    except (ModelError, SettingsError) as error:
        raise ModelError(f"'{path}': {error}") from error


def _figures(content: dict[str, Any], path: Path) -> Figures:
    tables = {kind: read_rows(content.pop(kind, []), kind, path.parent) for kind in LISTS}
    box = content.pop("box", None)
    whole = _checked(WholeFigures, content, "the spacecraft")
    parts = _all(PartFigures, tables["part"], "part")
    wheels = _all(WheelFigures, tables["wheel"], "wheel")
    if not wheels:
        raise ModelError("there is no wheel: give each a table [[wheel]], or wheel = 'wheels.csv'")
    body = _whole(whole, parts)
    return Figures(
        name=whole.name or path.stem,
        whole=body,
        wheels=tuple(_named(wheel, k) for k, wheel in enumerate(wheels, 1)),
        box=None if box is None else _checked(BoxFigures, box, "the box"),
        nominal_inertia_factors=whole.nominal_inertia_factors,
        timestep=whole.timestep or suited_timestep(body, wheels),
    )


def suited_timestep(whole: Body, wheels: list[WheelFigures]) -> float:
    """The usual step, s; for a craft much quicker or slower than the benchmark a round number near
    the same share of its own second."""
    weakest = min(math.inf if wheel.torque is None else wheel.torque for wheel in wheels)
    second = units_for(float(np.trace(whole.inertia)) / 3.0, weakest).time
    if 10.0 * SHORTEST * second <= USUAL <= 0.5 * LONGEST * second:
        return USUAL
    digit = 10.0 ** math.floor(math.log10(USUAL * second))
    return max(step for step in (digit, 2.0 * digit, 5.0 * digit) if step <= USUAL * second)


def _whole(figures: WholeFigures, parts: list[PartFigures]) -> Body:
    stated = figures.mass is not None or len(figures.inertia) > 0
    if stated == bool(parts):
        raise ModelError(
            "give mass and inertia of the whole spacecraft, or its parts ([[part]] or part = "
            f"'parts.csv'){', not both' if stated else ''}"
        )
    if parts:
        whole = joined([_body(part) for part in parts])
    elif figures.mass is None:
        raise ModelError("the mass of the whole spacecraft is missing: mass = ...")
    else:
        centre = np.array(figures.centre_of_mass)
        whole = Body(figures.mass, centre, _matrix(figures.inertia, "the whole spacecraft"))
    refuse_impossible(whole.inertia, "the whole spacecraft")
    return whole


def _body(part: PartFigures) -> Body:
    whose = f"part '{part.name}'"
    inertia = _matrix(part.inertia, whose) if part.inertia else np.zeros((3, 3))
    return Body(part.mass, np.array(part.position), inertia)


def _matrix(numbers: tuple[float, ...], whose: str) -> Matrix3:
    if len(numbers) not in (3, 6):
        raise ModelError(
            f"the inertia of {whose} has {len(numbers)} numbers: give xx yy zz, or "
            "xx yy zz xy xz yz"
        )
    xx, yy, zz, xy, xz, yz = (*numbers, 0.0, 0.0, 0.0)[:6]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _named(wheel: WheelFigures, number: int) -> WheelFigures:
    if wheel.name:
        return wheel
    values = {name: getattr(wheel, name) for name in wheel.__dataclass_fields__}
    return WheelFigures(**values | {"name": f"wheel_{number}"})


def _all(kind: type[S], rows: list[Any], what: str) -> list[S]:
    return [_checked(kind, row, f"{what} {k}") for k, row in enumerate(rows, 1)]


def _checked(kind: type[S], values: Any, whose: str) -> S:
    if not isinstance(values, Mapping):
        raise ModelError(f"{whose} must be a table of names and values")
    try:
        return built(kind, values)
    except SettingsError as error:
        raise ModelError(f"{whose}: {_FLAG.sub(_key, str(error))}") from error


def _key(flag: re.Match[str]) -> str:
    """A setting's flag as the key that it is in the file."""
    return flag[1].replace("-", "_")
