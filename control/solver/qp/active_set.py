"""A dense convex quadratic program by a primal-dual active-set method.

Suppose where every row ends, solve for v and the multipliers z, and correct what turned out wrong:
a row inside that broke its bound goes onto it, a row on its bound with a multiplier that pulls goes
inside, a soft row whose multiplier exceeds w goes beyond. When nothing changes, v is optimal, to
round-off. From a good supposition (the last solve's) that takes one or two factorisations, where
an interior point takes ten; from a bad one it may cycle, and `interior_point.py` takes over.
Source: Hintermueller, Ito and Kunisch, SIAM J. Optim. 13 (2002).

`active_set.h` does the same, step for step, with a Riccati recursion in place of the Cholesky.
"""

import numpy as np

from ...ground.arrays import Array
from .program import (
    AT_BOUND,
    BEYOND,
    INSIDE,
    Places,
    QpSolution,
    QuadraticProgram,
    cholesky,
    cholesky_solve,
)

STIFFNESS = 1e7  # of a row held on its bound, relative to the largest curvature
PASSES = 3  # the first leaves an error of 1 / STIFFNESS, later ones the round-off of a stiff system
BROKEN = 1e-10  # a row inside may exceed its bound by this, in its (order one) unit
MAX_ROUNDS = 6


def solve_active_set(program: QuadraticProgram, place: Places) -> QpSolution | None:
    """The optimum, supposing at first that rows end at `place`; None if the guesses go round."""
    v = np.zeros(len(program.g))
    for rounds in range(1, MAX_ROUNDS + 1):
        v, z = _solve_supposing(program, place, v)
        corrected = _corrected(program, place, program.D @ v, z)
        if np.array_equal(corrected, place):
            return QpSolution(v, z, place, rounds)
        place = corrected
    return None


def _solve_supposing(program: QuadraticProgram, place: Places, v: Array) -> tuple[Array, Array]:
    """v and z with the rows held on their bounds by stiff springs, refined by multipliers."""
    used = np.flatnonzero(place)
    D, side = program.D[used], np.sign(place[used])
    bound = np.where(side > 0, program.upper[used], program.lower[used])
    beyond = np.abs(place[used]) == BEYOND
    stiffness = STIFFNESS * np.max(np.diag(program.H))
    weight = np.where(beyond, program.w[used], stiffness)
    factor = cholesky(program.H + (D.T * weight) @ D)
    z = np.zeros(len(used))
    for _ in range(PASSES):
        push = np.where(beyond, side * weight, z) + weight * (D @ v - bound)
        step = cholesky_solve(factor, -(program.H @ v + program.g + push @ D))
        v, z = v + step, push + weight * (D @ step)
    multipliers = np.zeros(len(place))
    multipliers[used] = z
    return v, multipliers


def _corrected(program: QuadraticProgram, place: Places, row: Array, z: Array) -> Places:
    """Where the rows end, as this solution has it."""
    outside = (row > program.upper + BROKEN).astype(int) - (row < program.lower - BROKEN)
    side = np.sign(place)
    pull = z * side
    at_bound = np.where(pull < 0.0, INSIDE, np.where(pull > program.softness, BEYOND, AT_BOUND))
    beyond = np.where(outside == side, BEYOND, AT_BOUND)
    return np.where(
        place == INSIDE, outside, side * np.where(np.abs(place) == BEYOND, beyond, at_bound)
    )
