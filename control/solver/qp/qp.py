"""A step's quadratic program: the active set first, the interior point where that goes round."""

from dataclasses import replace

from .active_set import MAX_ROUNDS, solve_active_set
from .interior_point import solve_interior_point
from .program import Places, QpSolution, QuadraticProgram


def solve_qp(program: QuadraticProgram, place: Places) -> QpSolution:
    """The optimum, supposing at first that rows end at `place`.

    The interior point's answer is polished: it tells the active set where the rows end.
    """
    solution = solve_active_set(program, place)
    if solution is not None:
        return solution
    rough = solve_interior_point(program)
    polished = solve_active_set(program, rough.place)
    spent = MAX_ROUNDS + rough.factorizations
    if polished is None:
        return replace(rough, factorizations=spent + MAX_ROUNDS)
    return replace(polished, factorizations=spent + polished.factorizations)
