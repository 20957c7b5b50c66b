"""Solving an optimal control problem: one interface, compiled or interpreted."""

from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np

from ..ground.arrays import Array
from .compiled.solver import compile_solver
from .interpreted import InterpretedSolver
from .ocp import Ocp
from .solution import Kkt, Solution, SolverSettings, SolverStatus

__all__ = [
    "Kkt",
    "Solution",
    "SolverSettings",
    "SolverStatus",
    "roll_out",
    "solve_ocp",
    "solver_of",
]


@runtime_checkable
class Solver(Protocol):
    """What another solver must offer."""

    def roll_out(self, x0: Array, u: Array, p: Array) -> tuple[Array, float]:
        """States and cost of given inputs."""

    def solve(self, x0: Array, guess: Array, p: Array, settings: SolverSettings) -> Solution:
        """Best inputs from a guess."""


@lru_cache(maxsize=32)
def solver_of(ocp: Ocp, backend: str) -> Solver:
    """The problem's solver, built once: compiled where that works, unless told otherwise."""
    compiled = None if backend == "interpreted" else compile_solver(ocp)
    return compiled or InterpretedSolver(ocp)


def solve_ocp(
    ocp: Ocp, x0: Array, guess: Array, p: Array, settings: SolverSettings | None = None
) -> Solution:
    """Best inputs from state x0 (nx) and guess (N, nu), and the evidence that they are.

    p is one parameter vector (np) for all stages, or one for each, shape (N + 1, np).
    """
    settings = settings or SolverSettings()
    p = np.broadcast_to(p, (ocp.N + 1, ocp.np))
    return solver_of(ocp, settings.backend).solve(x0, guess, p, settings)


def roll_out(
    ocp: Ocp, x0: Array, u: Array, p: Array, settings: SolverSettings | None = None
) -> tuple[Array, float]:
    """States (N + 1, nx) that inputs u (N, nu) lead to, and their cost: no optimisation."""
    settings = settings or SolverSettings()
    p = np.broadcast_to(p, (ocp.N + 1, ocp.np))
    return solver_of(ocp, settings.backend).roll_out(x0, u, p)
