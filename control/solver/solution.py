"""What a solver is told and what it answers."""

from dataclasses import dataclass
from enum import Enum
from typing import Literal

from ..ground.arrays import Array
from ..ground.settings import Count, NotNegative, Settings


@dataclass(frozen=True)
class SolverSettings(Settings, group="nmpc.solver"):
    """When to stop, and which of the two implementations runs."""

    max_iterations: Count = 30
    """Newton steps at most. The solver counts steps, never time, so a run repeats exactly."""
    tolerance: NotNegative = 1e-8
    """Stop when a step lowers the cost by less than this fraction of it."""
    damping: NotNegative = 1e-8
    """Added to the Hessian of each input (cost per input squared): keeps it regular where a cost of
    fourth powers goes flat, and does not move the optimum."""
    backend: Literal["auto", "interpreted"] = "auto"
    """auto compiles the stage functions when a C compiler is found and interprets them otherwise:
    the commands are the same, compiled is about ten times faster."""


class SolverStatus(Enum):
    """How a solve ended, as a sentence."""

    SOLVED = "The solver found an optimum."
    ITERATION_LIMIT = "The solver used all its iterations; its best plan is kept."
    FAILED = "The solver met numbers that are not finite and has no plan."


@dataclass(frozen=True)
class Kkt:
    """How far a solution is from satisfying the first-order conditions of optimality."""

    stationarity: float
    """Largest component of the Lagrangian's gradient by the inputs, cost per unit of input."""
    feasibility: float
    """Largest violation of a hard row, in that row's unit. The dynamics hold by roll-out."""
    complementarity: float
    """Largest multiplier times distance to its limit, in units of cost."""


@dataclass(frozen=True)
class Solution:
    """Inputs, the states they lead to, and the evidence."""

    u: Array
    """Shape (N, nu)."""
    x: Array
    """Shape (N + 1, nx), rolled out from x_0 with u."""
    objective: float
    """Cost including what violated soft rows cost."""
    kkt: Kkt
    iterations: int
    """Newton and Gauss-Newton steps taken."""
    factorizations: int
    """Matrix factorisations by the quadratic programs of all steps."""
    status: SolverStatus
