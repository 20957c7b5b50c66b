"""Studies: one campaign for every combination of some settings' values.

A setting is named as on the command line (`nominal.mismatch`, `environment.f107`); a study file is
TOML that lists the values of each:

    nominal.mismatch = [0, 1, 2]
    model = ["two_wheel", "two_wheel_friction"]
"""

import contextlib
import io
import itertools
import math
import tomllib
import typing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import tyro

from simsat.campaign.inputs import read_given
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import Settings, changed, hints, setting, wanted

POINTS_MAX = 10_000  # each a campaign of its own

S = TypeVar("S", bound=Settings)
Point = dict[str, str]
"""One combination: the value of every varied setting, as text."""

CHOSEN_OTHERWISE = {
    "controller": "--controllers",
    "axis": "--attitudes",
    "angle_deg": "--attitudes",
}


@dataclass(frozen=True)
class Variation:
    """A setting and the values to try."""

    name: str
    """Dotted field name, `nominal.mismatch`."""
    values: tuple[str, ...]
    """As on the command line; the numbers of a tuple are separated by spaces."""


def parse_variation(text: str) -> Variation:
    """The variation that `--vary NAME=VALUE,VALUE` asks for.

    Raises `SettingsError` if it has no name or no values.
    """
    name, equals, values = text.partition("=")
    listed = tuple(value.strip() for value in values.split(","))
    if not equals or not name.strip() or not all(listed):
        raise SettingsError(f"--vary takes NAME=VALUE,VALUE,..., got '{text}'")
    return _variation(_field_name(name), listed)


def read_study(path: Path) -> tuple[Variation, ...]:
    """The variations of a study file.

    Raises `SettingsError` that names the file and what is wrong in it.
    """
    try:
        variations = tuple(_listed(tomllib.loads(read_given(path, "study")), "", path))
    except ValueError as error:  # no TOML, or a number of too many digits
        raise SettingsError(f"'{path}' is no TOML: {error}") from error
    except RecursionError:
        raise SettingsError(f"'{path}' is nested too deeply") from None
    if not variations:
        raise SettingsError(f"'{path}' varies nothing; write lines like nominal.mismatch = [0, 1]")
    return variations


def _listed(table: dict[str, Any], prefix: str, path: Path) -> typing.Iterator[Variation]:
    for key, value in table.items():
        name = prefix + _field_name(key)
        if isinstance(value, dict):
            yield from _listed(value, f"{name}.", path)
        elif isinstance(value, list) and value:
            yield _variation(name, tuple(map(_text, value)))
        else:
            raise SettingsError(f"{path}: {name} must be a list of values, got {value!r}")


def _text(value: Any) -> str:
    return " ".join(map(str, value)) if isinstance(value, list) else str(value)


def _field_name(flag: str) -> str:
    return flag.strip().removeprefix("--").replace("-", "_")


def _variation(name: str, values: tuple[str, ...]) -> Variation:
    twice = sorted({value for value in values if values.count(value) > 1})
    if twice:
        raise SettingsError(f"'{name}' lists {', '.join(twice)} more than once")
    return Variation(name, values)


def grid(variations: tuple[Variation, ...]) -> tuple[Point, ...]:
    """Every combination of the values, the last setting changing fastest.

    No variation makes one point that changes nothing. Raises `SettingsError` for a setting that
    is varied twice or that a campaign chooses by other means.
    """
    names = [variation.name for variation in variations]
    for name in names:
        if names.count(name) > 1:
            raise SettingsError(f"'{name}' is varied twice; list all its values once")
        if name in CHOSEN_OTHERWISE:
            raise SettingsError(f"'{name}' is chosen by {CHOSEN_OTHERWISE[name]}, not varied")
    points = math.prod(len(variation.values) for variation in variations)
    if points > POINTS_MAX:
        raise SettingsError(f"the study has {points} points, more than {POINTS_MAX}")
    values = itertools.product(*(variation.values for variation in variations))
    return tuple(dict(zip(names, combination, strict=True)) for combination in values)


def label(point: Point) -> str:
    """A point in a few words, empty for the one that changes nothing."""
    return ", ".join(f"{name}={value}" for name, value in point.items())


def at_point(settings: S, point: Point) -> S:
    """The settings with the point's values put in.

    Raises `SettingsError` for a name that is no setting or a value that does not fit it.
    """
    for name, value in point.items():
        hint, now = setting(settings, name)
        if isinstance(now, Settings):
            inside = ", ".join(hints(type(now)))
            raise SettingsError(f"'{name}' is a group; vary one of {inside} in it")
        settings = changed(settings, {name: _convert(hint, name, value)})
    return settings


def _convert(hint: Any, name: str, value: str) -> Any:
    """The text as the command line would read it."""
    text = value.capitalize() if value.lower() in ("true", "false", "none") else value
    words = [value] if hint in (str, Path) else text.split()
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            return tyro.cli(hint, args=words, console_outputs=False)
    except SystemExit:
        raise SettingsError(
            f"'{value}' does not fit the setting '{name}': give {wanted(hint)}"
        ) from None
