"""The intervals of a plan: single periods at both ends, and longer ones between them.

A plan is a torque for every period. It is solved for on intervals of whole periods, never more than
a few dozen, so that a plan of any length costs as much. Where the next command and the arrival are
decided an interval is one period. Those between are as long as it takes, counted from the end: from
one period to the next the first of them grows shorter and the others stay where they are.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array

MOST = 64  # intervals: the benchmark's slews, 25 s at most, are planned by single periods
FIRST, LAST = 8, 16  # single periods at the start, where estimates still change, and at the end

Lengths: TypeAlias = NDArray[np.int64]
"""Periods that each interval takes."""


def interval_lengths(periods: int, even: bool) -> Lengths:
    """The intervals of a plan of so many periods: single periods if they must be `even`."""
    between = periods - FIRST - LAST
    if even or periods <= MOST:
        return np.ones(periods, np.int64)
    size = -(-between // (MOST - FIRST - LAST))
    whole, rest = divmod(between, size)
    sizes = [rest] * (rest > 0) + [size] * whole
    return np.array([1] * FIRST + sizes + [1] * LAST)


def seconds(lengths: Lengths, period: float) -> Array:
    """How long each interval is, s."""
    return lengths.astype(float) * period


def gathered(torque: Array, lengths: Lengths) -> Array:
    """The torque of each interval that has the impulse of its periods, (K, m) to (N, m)."""
    starts = np.cumsum(lengths) - lengths
    mean: Array = np.add.reduceat(torque, starts) / lengths[:, None]
    return mean


def spread(torque: Array, lengths: Lengths) -> Array:
    """The torque of each period, (N, m) to (K, m)."""
    return np.repeat(torque, lengths, axis=0)
