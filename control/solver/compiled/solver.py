"""The solver in C: CasADi's generated stage functions and METHOD, compiled as one library."""

import ctypes
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from ...ground.arrays import Array
from ..ocp import Ocp
from ..solution import Kkt, Solution, SolverSettings, SolverStatus
from ..stage import Stage
from .library import load_library

METHOD = tuple(
    Path(__file__).with_name(name)
    for name in ("riccati.h", "active_set.h", "interior_point.h", "sqp.c")
)
EXPORTS = ("solver_size", "solver_problem", "solver_roll_out", "solver_solve")  # of sqp.c
STATUS = (SolverStatus.SOLVED, SolverStatus.ITERATION_LIMIT, SolverStatus.FAILED)  # of sqp.c


class Report(ctypes.Structure):
    """`Report` of sqp.c."""

    _fields_ = (
        ("cost", ctypes.c_double),
        ("stationarity", ctypes.c_double),
        ("feasibility", ctypes.c_double),
        ("complementarity", ctypes.c_double),
        ("iterations", ctypes.c_int),
        ("factorizations", ctypes.c_int),
        ("status", ctypes.c_int),
    )


class CompiledSolver:
    """Work space of one problem, and the library that solves it."""

    def __init__(self, ocp: Ocp, library: Any) -> None:
        self.ocp = ocp
        self._library = _declared(library)
        self._space = ctypes.create_string_buffer(self._library.solver_size() + 64)
        aligned = -ctypes.addressof(self._space) % 64
        self._solver = ctypes.c_void_p(ctypes.addressof(self._space) + aligned)
        limits = ocp.limits
        self._library.solver_problem(
            self._solver,
            np.ascontiguousarray(np.concatenate([limits.Cx, limits.Cu], axis=1)).ctypes,
            np.ascontiguousarray(limits.lower).ctypes,
            np.ascontiguousarray(limits.upper).ctypes,
            np.where(np.isfinite(limits.softness), limits.softness, 0.0).ctypes,
            limits.on_input.astype(np.intc).ctypes,
            _plain(ocp.coefficients).ctypes,
        )

    def roll_out(self, x0: Array, u: Array, p: Array) -> tuple[Array, float]:
        """States (N + 1, nx) that the inputs lead to, and the cost with what soft rows cost."""
        x = np.empty((self.ocp.N + 1, self.ocp.nx))
        cost = self._library.solver_roll_out(
            self._solver, _plain(x0).ctypes, _plain(u).ctypes, _plain(p).ctypes, x.ctypes
        )
        return x, cost

    def solve(self, x0: Array, guess: Array, p: Array, settings: SolverSettings) -> Solution:
        """Best inputs from a guess (N, nu); p has a row for each of the N + 1 stages."""
        x = np.empty((self.ocp.N + 1, self.ocp.nx))
        u = np.array(guess, float, order="C")
        report = Report()
        self._library.solver_solve(
            self._solver,
            _plain(x0).ctypes,
            u.ctypes,
            _plain(p).ctypes,
            x.ctypes,
            settings.max_iterations,
            settings.tolerance,
            settings.damping,
            ctypes.byref(report),
        )
        kkt = Kkt(report.stationarity, report.feasibility, report.complementarity)
        status = STATUS[report.status]
        return Solution(u, x, report.cost, kkt, report.iterations, report.factorizations, status)


def compile_solver(ocp: Ocp) -> CompiledSolver | None:
    """The problem's compiled solver, from the cache if it is there; None without a compiler."""
    library = load_library(source(ocp.stage, ocp.N, len(ocp.limits.lower)), EXPORTS)
    return None if library is None else CompiledSolver(ocp, library)


@lru_cache(maxsize=16)
def source(stage: Stage, N: int, rows: int) -> str:
    """The whole C source of all problems with a stage, horizon and number of rows: stage functions,
    sizes, method."""
    functions = {
        name: getattr(stage, name)
        for name in (
            "evaluate", "linearize", "curvature", "evaluate_end", "linearize_end", "curvature_end"
        )
    }  # fmt: skip
    generator = ca.CodeGenerator("stage.c", {"with_header": False})
    for function in functions.values():
        generator.add(function)
    sizes = {
        "N": N,
        "NX": stage.nx,
        "NU": stage.nu,
        "NP": stage.np,
        "NC": stage.nc,
        "NR": stage.evaluate.numel_out(1),
        "NE": stage.evaluate_end.numel_out(0),
        "M": rows,
        "WORK": _largest(function.sz_w() for function in functions.values()),
        "IWORK": _largest(function.sz_iw() for function in functions.values()),
        "ARGS": _largest(max(f.sz_arg(), f.sz_res()) for f in functions.values()),
    }
    lines = [f"#define {name} {value}" for name, value in sizes.items()]
    return "\n".join([generator.dump(), *lines, *(path.read_text() for path in METHOD)])


def _largest(sizes: Iterable[int]) -> int:
    return max(sizes)


def _plain(values: Array) -> Array:
    return np.ascontiguousarray(values, float)


def _declared(library: Any) -> Any:
    """The library's functions with the types of their arguments."""
    array, pointer = ctypes.c_void_p, ctypes.c_void_p
    library.solver_size.restype = ctypes.c_size_t
    library.solver_problem.argtypes = [pointer, array, array, array, array, array, array]
    library.solver_problem.restype = None
    library.solver_roll_out.argtypes = [pointer, array, array, array, array]
    library.solver_roll_out.restype = ctypes.c_double
    library.solver_solve.argtypes = [
        pointer, array, array, array, array,
        ctypes.c_int, ctypes.c_double, ctypes.c_double, pointer,
    ]  # fmt: skip
    library.solver_solve.restype = None
    return library
