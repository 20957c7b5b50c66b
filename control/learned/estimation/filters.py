"""The filter to estimate with: compiled where that works, else interpreted, the result the same."""

from collections.abc import Callable
from functools import lru_cache
from typing import TypeAlias

from .compiled_filter import compile_filter
from .estimate import ModelEstimate
from .filter import filtered
from .samples import Samples

Filter: TypeAlias = Callable[[ModelEstimate, Samples, float], ModelEstimate]
"""(estimate, samples, least gyro noise to assume in rad/s, 1 sigma) -> the estimate after all
samples newer than itself."""


@lru_cache(maxsize=2)
def choose_filter(backend: str) -> Filter:
    """Compiled where that works, unless told "interpreted"."""
    compiled = None if backend == "interpreted" else compile_filter()
    return compiled or filtered
