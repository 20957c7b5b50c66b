"""Errors of instruments drawn beforehand, one row per sample of a flight, some hours at a time.

Every row is decided by the seed alone, so that a flight can be flown again and may last for days.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from simsat.control.ground.arrays import Array

BLOCK = 200_000  # rows drawn at once: 10,000 s at 20 Hz, some 25 MB
KEPT = 2  # blocks


class Errors(NamedTuple):
    """Errors at k samples."""

    attitude: Array
    """Small rotation in body axes, rad, shape (k, 3)."""
    gyro: Array
    """rad/s, shape (k, 3)."""
    wheel_speed: Array
    """rad/s, shape (k, m)."""
    relative: Array
    """Factors on attitude, rate and wheel speeds less one, shape (k, 6 + m)."""


class ErrorTable:
    """Rows of errors, drawn when a flight first comes to them.

    `draw` answers so many rows from a generator. The first block is drawn from `rng`, the further
    ones each from a stream of its own.
    """

    def __init__(
        self,
        draw: Callable[[np.random.Generator, int], Errors],
        rng: np.random.Generator,
        rows: int,
        seed: int,
    ):
        self._draw, self._seed = draw, seed
        self._first = draw(rng, min(rows, BLOCK))
        self._later: dict[int, Errors] = {}

    def rows(self, first: int, last: int) -> Errors:
        """Those from the sample `first` to `last`, both included."""
        parts = []
        for block in range(first // BLOCK, last // BLOCK + 1):
            drawn, start = self._block(block), block * BLOCK
            inside = slice(max(first - start, 0), last + 1 - start)
            parts.append(Errors(*(part[inside] for part in drawn)))
        if len(parts) == 1:
            return parts[0]
        return Errors(*(np.concatenate(both) for both in zip(*parts, strict=True)))

    def _block(self, block: int) -> Errors:
        if block == 0:
            return self._first
        if block not in self._later:
            rng = np.random.default_rng((self._seed, 0, block))
            self._later = {k: v for k, v in self._later.items() if k > block - KEPT}
            self._later[block] = self._draw(rng, BLOCK)
        return self._later[block]
