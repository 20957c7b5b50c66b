"""The Kalman filter in C: filter.c and the constants of `filter`, compiled as a library."""

import ctypes
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...ground.arrays import Array
from ...solver.compiled.library import load_library
from .appendage_process import CORRELATION_TIME, DEFLECTION_TIME
from .balance import measurement_matrix, measurement_noise
from .estimate import APPENDAGE, FIELD, INERTIA, MOMENTUM, UNKNOWNS, ModelEstimate
from .external_torque import PAIRS, torque_map
from .filter import QUIET, is_new, walk
from .samples import Samples

METHOD = Path(__file__).with_name("filter.c")
EXPORTS = ("filter_samples",)
FIELDS = FIELD.stop - FIELD.start


class CompiledFilter:
    """See `filters.Filter`."""

    def __init__(self, library: Any) -> None:
        self._run = library.filter_samples
        self._run.argtypes = [ctypes.c_int, *[ctypes.c_void_p] * 3]
        self._run.restype = None

    def __call__(
        self, estimate: ModelEstimate, samples: Samples, rate_noise: float
    ) -> ModelEstimate:
        """The estimate after all samples newer than itself."""
        noise = measurement_noise(estimate.J, samples, rate_noise)
        numbers = [noise, estimate.flexibility, CORRELATION_TIME, DEFLECTION_TIME, QUIET]
        process = np.concatenate([numbers, walk(estimate.outside)])
        new = _rows(estimate, samples)[is_new(estimate, samples)]
        state = _packed(estimate)
        self._run(len(new), new.ctypes.data, process.ctypes.data, state.ctypes.data)
        return _unpacked(estimate, state)


def compile_filter() -> CompiledFilter | None:
    """The compiled filter, from the cache if it is there; None without a compiler."""
    library = load_library(source(), EXPORTS)
    return None if library is None else CompiledFilter(library)


def source() -> str:
    """The whole C source: the places of the unknowns, and the method."""
    places = {
        "UNKNOWNS": UNKNOWNS,
        "INERTIA": INERTIA.start,
        "MOMENTUM": MOMENTUM.start,
        "FIELD": FIELD.start,
        "FIELDS": FIELDS,
        "APPENDAGE": APPENDAGE.start,
    }
    pairs = ", ".join(f"{{{i}, {j}}}" for i, j in PAIRS)
    return "\n".join(
        [
            "#include <math.h>",
            "#include <string.h>",
            *(f"#define {name} {value}" for name, value in places.items()),
            f"static const int PAIRS[{len(PAIRS)}][2] = {{{pairs}}};",
            METHOD.read_text(),
        ]
    )


def _rows(estimate: ModelEstimate, samples: Samples) -> Array:
    """Each sample as `Sample` of filter.c has it."""
    count = len(samples.t)
    maps = torque_map(samples.q, estimate.J).reshape(count, -1)
    H = measurement_matrix(samples).reshape(count, -1)
    return np.column_stack(
        [samples.t, maps, H, samples.wheel_momentum, samples.omega, samples.known_torque]
    )


def _packed(estimate: ModelEstimate) -> Array:
    """`Estimate` of filter.c."""
    P, field_map = estimate.covariance.ravel(), estimate.torque_map.ravel()
    return np.concatenate([estimate.mean, P, [estimate.t], field_map, estimate.deflection])


def _unpacked(estimate: ModelEstimate, state: Array) -> ModelEstimate:
    ends = np.cumsum([UNKNOWNS, UNKNOWNS**2, 1, 3 * FIELDS])
    mean, P, t, field_map, deflection = np.split(state, ends)
    return replace(
        estimate,
        mean=mean,
        covariance=P.reshape(UNKNOWNS, UNKNOWNS),
        t=float(t[0]),
        torque_map=field_map.reshape(3, FIELDS),
        deflection=deflection,
    )
