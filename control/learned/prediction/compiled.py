"""Propagation in C: CasADi's generated functions and propagate.c, compiled as one library."""

import ctypes
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from ...ground.arrays import Array, Quaternion
from ...model.momentum import MomentumModel
from ...solver.compiled.library import load_library
from .interpreted import known_of
from .interval import IntervalFunctions

METHOD = Path(__file__).with_name("propagate.c")
EXPORTS = ("plan_propagate", "plan_linearize")  # of propagate.c


class CompiledPropagator:
    """See `propagation.Propagator`."""

    def __init__(self, functions: IntervalFunctions, numbers: Array, library: Any) -> None:
        self._functions, self._numbers = functions, np.ascontiguousarray(numbers, float)
        self._library = _declared(library)
        self.even = functions.even

    def end(
        self, model: MomentumModel, x0: Array, torque: Array, lengths: Array, goal: Quaternion
    ) -> Array:
        """Where the plan ends."""
        end = np.empty(self._functions.conditions)
        self._run(self._library.plan_propagate, model, x0, torque, lengths, goal, end)
        return end

    def linearize(
        self, model: MomentumModel, x0: Array, torque: Array, lengths: Array, goal: Quaternion
    ) -> tuple[Array, Array, Array]:
        """End, slope and states."""
        (K, m), nx, ne = torque.shape, len(x0), self._functions.conditions
        end, slope, F = np.empty(ne), np.empty((ne, K * m)), np.empty((K, nx + m, nx))
        linearize = self._library.plan_linearize
        x = self._run(linearize, model, x0, torque, lengths, goal, end, slope, F)
        return end, slope, x

    def _run(
        self,
        function: Any,
        model: MomentumModel,
        x0: Array,
        torque: Array,
        lengths: Array,
        goal: Quaternion,
        *results: Array,
    ) -> Array:
        """The states, with `results` filled in."""
        assert torque.shape == (len(lengths), self._functions.wheels)
        x = np.empty((len(torque) + 1, self._functions.states))
        x[0] = x0
        given = [_plain(part) for part in (torque, lengths, known_of(model), self._numbers, goal)]
        function(len(torque), *(array.ctypes.data for array in (x, *given, *results)))
        return x


def compile_propagator(functions: IntervalFunctions, numbers: Array) -> CompiledPropagator | None:
    """The compiled propagator, from the cache if it is there; None without a compiler."""
    library = load_library(source(functions), EXPORTS)
    return None if library is None else CompiledPropagator(functions, numbers, library)


@lru_cache(maxsize=8)
def source(functions: IntervalFunctions) -> str:
    """The whole C source: the functions, their sizes, the method."""
    every = (functions.step, functions.step_slope, functions.end, functions.end_slope)
    generator = ca.CodeGenerator("plan.c", {"with_header": False})
    for function in every:
        generator.add(function)
    sizes = {
        "NX": functions.states,
        "NU": functions.wheels,
        "NE": functions.conditions,
        "WORK": max(function.sz_w() for function in every),
        "IWORK": max(function.sz_iw() for function in every),
        "ARGS": max(max(function.sz_arg(), function.sz_res()) for function in every),
    }
    lines = [f"#define {name} {value}" for name, value in sizes.items()]
    return "\n".join([generator.dump(), "#include <string.h>", *lines, METHOD.read_text()])


def _plain(values: Array) -> Array:
    return np.ascontiguousarray(values, float)


def _declared(library: Any) -> Any:
    """The library's functions with the types of their arguments."""
    for name, arrays in (("plan_propagate", 7), ("plan_linearize", 9)):
        function = getattr(library, name)
        function.argtypes = [ctypes.c_int, *[ctypes.c_void_p] * arrays]
        function.restype = None
    return library
