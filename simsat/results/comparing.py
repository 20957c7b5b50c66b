"""Results kept and flown again, figure by figure: the same to the last bit, or how far apart."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from simsat.control.ground.arrays import Array

Figures = Mapping[str, Any]
"""What a flight came to: metrics by name, groups of them as dictionaries, series as arrays."""


@dataclass(frozen=True)
class Difference:
    """A figure that did not come out again."""

    where: str
    """The run."""
    name: str
    kept: Any
    flown: Any

    @property
    def size(self) -> float:
        """Largest distance of the two; infinite where they are no numbers or not as many."""
        try:
            kept, flown = np.asarray(self.kept, float), np.asarray(self.flown, float)
            distance = float(np.max(np.abs(kept - flown)))
        except (TypeError, ValueError):
            return math.inf
        return distance if math.isfinite(distance) else math.inf

    def __str__(self) -> str:
        if math.isfinite(self.size):
            return f"{self.name}: {self.size:.3g} apart in {self.where}"
        return f"{self.name}: {_short(self.kept)} kept, {_short(self.flown)} flown in {self.where}"


def compared(where: str, kept: Figures, flown: Figures) -> list[Difference]:
    """Every figure of a run that differs, or that only one of the two has."""
    one, other = flat(kept), flat(flown)
    return [
        Difference(where, name, one.get(name), other.get(name))
        for name in dict.fromkeys([*one, *other])
        if not _same(one.get(name), other.get(name))
    ]


def flat(nested: Figures, prefix: str = "") -> dict[str, Any]:
    """Names of groups and figures joined by dots."""
    figures: dict[str, Any] = {}
    for name, value in nested.items():
        inner = isinstance(value, Mapping)
        figures |= flat(value, f"{prefix}{name}.") if inner else {prefix + name: value}
    return figures


def _same(kept: Any, flown: Any) -> bool:
    if isinstance(kept, np.ndarray) and isinstance(flown, np.ndarray):
        return np.array_equal(kept, flown, equal_nan=True)
    return type(kept) is type(flown) and kept == flown


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        array: Array = value
        return f"{array.size} values"
    return "nothing" if value is None else str(value)
