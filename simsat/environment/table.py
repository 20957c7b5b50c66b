"""A function of time that is costly to ask, sampled beforehand and interpolated.

It is sampled hour by hour, when a flight first comes there, so that a flight may last as long as it
likes; only the last hours are kept.
"""

from collections import OrderedDict
from collections.abc import Callable, Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from simsat.control.ground.arrays import Array
from simsat.environment.components import Number

HOUR = 3600.0  # s, a block
MARGIN = 4  # samples beyond both ends of a block: there its spline is that of its neighbour, 1e-8
KEPT = 4  # blocks

Cell = Sequence[tuple[float, float, float, float]]
"""Coefficients of one interval, from the third power down, for each component."""


class Table:
    """A vector function of time as cubic splines between samples `step` (s) apart.

    `sample` answers arrays of times (k,) with values (k, n). The step must divide an hour.
    """

    def __init__(self, sample: Callable[[Array], Array], step: float):
        self._sample, self._step = sample, step
        self._cells_per_block = round(HOUR / step)
        self._splines: OrderedDict[int, CubicSpline] = OrderedDict()
        self._block: int | None = None
        self._cells: list[Cell] = []

    def __call__(self, t: Number) -> tuple[Number, ...]:
        """The components at an instant (floats), or at an array of them (arrays)."""
        if isinstance(t, float):
            return self._at(t)
        t = np.asarray(t, float)
        blocks = np.floor_divide(t, HOUR).astype(int)
        values = [np.empty((*t.shape, 1))]
        for block in np.unique(blocks):
            inside = blocks == block
            found = self._spline(int(block))(t[inside])
            if values[0].shape[-1] != found.shape[-1]:
                values[0] = np.empty((*t.shape, found.shape[-1]))
            values[0][inside] = found
        return tuple(np.moveaxis(values[0], -1, 0))

    def _at(self, t: float) -> tuple[float, ...]:
        block, into = divmod(t, HOUR)
        if block != self._block:
            c = self._spline(int(block)).c  # (4, intervals, components)
            self._cells = [[tuple(part) for part in cell] for cell in np.transpose(c, (1, 2, 0))]
            self._block = int(block)
        cell, share = divmod(into / self._step, 1.0)
        x = share * self._step
        return tuple(
            ((a * x + b) * x + c) * x + d for a, b, c, d in self._cells[int(cell) + MARGIN]
        )

    def _spline(self, block: int) -> CubicSpline:
        """The spline of a block, with its margins."""
        if block not in self._splines:
            nodes = self._step * np.arange(-MARGIN, self._cells_per_block + MARGIN + 1, dtype=float)
            t: Array = block * HOUR + nodes
            self._splines[block] = CubicSpline(t, self._sample(t))
            if len(self._splines) > KEPT:
                self._splines.popitem(last=False)
        return self._splines[block]
