"""Settings whose defaults are in the craft's own units (`units`).

    period: Annotated[Positive | None, Own("time", 0.5)] = None

Given, such a setting is in SI. Not given it is None, and stands for so many of the craft's own
units. `resolved` puts numbers for all that wasn't given, and `in_units` turns numbers in SI into
those of a controller that works in own units.
"""

import typing
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

from .settings import Settings, changed, hints
from .units import Units

S = TypeVar("S", bound=Settings)


@dataclass(frozen=True)
class Own:
    """Marks a setting as one that has a unit."""

    unit: str
    """Name of the unit in `Units`."""
    default: float | None = None
    """In own units; None where not given is a value of its own."""


def resolved(settings: S, units: Units) -> S:
    """The settings with a number in SI for each that wasn't given."""

    def in_si(mark: Own, value: float | None) -> float | None:
        if value is None and mark.default is not None:
            return mark.default * getattr(units, mark.unit)
        return value

    return _mapped(settings, in_si)


def in_units(settings: S, units: Units) -> S:
    """The settings with their numbers in the craft's own units, in which a default needs no
    number."""

    def converted(mark: Own, value: float | None) -> float | None:
        return None if value is None else value / getattr(units, mark.unit)

    return _mapped(settings, converted)


def numbers(settings: Settings) -> dict[str, float | None]:
    """The settings that have a unit by dotted name, `nmpc.period`."""
    found: dict[str, float | None] = {}
    for name, hint in hints(type(settings)).items():
        value = getattr(settings, name)
        if isinstance(value, Settings):
            found |= {f"{name}.{inner}": number for inner, number in numbers(value).items()}
        elif _mark(hint) is not None:
            found[name] = value
    return found


def own(settings: Settings, name: str) -> float:
    """A setting's number: as given, else its default in own units.

    For settings that are `resolved` or `in_units`, so that either is in the reader's units.
    """
    value, mark = getattr(settings, name), _mark(hints(type(settings))[name])
    assert mark is not None
    number = mark.default if value is None else value
    assert number is not None
    return float(number)


def _mapped(settings: S, convert: Callable[[Own, float | None], float | None]) -> S:
    changes: dict[str, Any] = {}
    for name, hint in hints(type(settings)).items():
        value, mark = getattr(settings, name), _mark(hint)
        if isinstance(value, Settings):
            changes[name] = _mapped(value, convert)
        elif mark is not None:
            changes[name] = convert(mark, value)
    return changed(settings, changes)


def _mark(hint: Any) -> Own | None:
    if typing.get_origin(hint) is not Annotated:
        return None
    return next((extra for extra in typing.get_args(hint) if isinstance(extra, Own)), None)
