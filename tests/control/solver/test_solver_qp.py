"""A step's quadratic program: both methods against each other and against optimality itself."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from simsat.control.solver.qp.active_set import solve_active_set
from simsat.control.solver.qp.interior_point import solve_interior_point
from simsat.control.solver.qp.program import QpSolution, QuadraticProgram
from simsat.control.solver.qp.qp import solve_qp


def random_program(seed: int, soft: bool = True) -> QuadraticProgram:
    """Twelve unknowns, ten rows of which some end inside, on, and (soft ones) beyond a bound."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(20, 12))
    softness = np.where(np.arange(10) < 5, rng.uniform(0.5, 3.0, 10), np.inf)
    return QuadraticProgram(
        H=root.T @ root,
        g=20.0 * rng.normal(size=12),
        D=rng.normal(size=(10, 12)),
        lower=-rng.uniform(0.1, 0.5, 10),
        upper=rng.uniform(0.1, 0.5, 10),
        softness=softness if soft else np.full(10, np.inf),
    )


def assert_optimal(program: QuadraticProgram, solution: QpSolution, accuracy: float) -> None:
    """Stationarity, rows, and multipliers that push only where a bound is met; soft rows push with
    w + w s when they are beyond it by s."""
    v, z = solution.v, solution.multipliers
    np.testing.assert_allclose(program.H @ v + program.g + z @ program.D, 0.0, atol=accuracy)
    row = program.D @ v
    for value, low, high, w, push in zip(
        row, program.lower, program.upper, program.softness, z, strict=True
    ):
        side, bound = (1.0, high) if push > 0.0 else (-1.0, low)
        beyond = side * (value - bound)
        if beyond > accuracy:
            assert side * push == pytest.approx(w + w * beyond, abs=accuracy)
        elif abs(push) > accuracy:
            assert beyond == pytest.approx(0.0, abs=accuracy)
            assert abs(push) < w + accuracy


@pytest.mark.parametrize("seed", range(30))
def test_both_methods_reach_the_optimum(seed: int) -> None:
    program = random_program(seed)
    assert_optimal(program, solve_interior_point(program), 1e-3)
    assert_optimal(program, solve_qp(program, np.zeros(10, int)), 1e-8)


def test_the_programs_put_rows_everywhere() -> None:
    """The cases above really have rows inside, on and beyond their bounds."""
    places = {p for s in range(30) for p in solve_qp(random_program(s), np.zeros(10, int)).place}
    assert places == {-2, -1, 0, 1, 2}


@pytest.mark.parametrize("seed", range(10))
def test_a_wrong_supposition_leads_to_the_same_optimum(seed: int) -> None:
    program = random_program(seed)
    wrong = np.random.default_rng(seed).integers(-1, 2, 10)
    from_nothing, from_wrong = solve_qp(program, np.zeros(10, int)), solve_qp(program, wrong)
    np.testing.assert_allclose(from_wrong.v, from_nothing.v, atol=1e-9)


def test_the_right_supposition_takes_one_factorisation() -> None:
    program = random_program(3)
    solution = solve_qp(program, np.zeros(10, int))
    again = solve_active_set(program, solution.place)
    assert again is not None
    assert again.factorizations == 1
    np.testing.assert_allclose(again.v, solution.v, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_a_box_agrees_with_bounded_least_squares(seed: int) -> None:
    """SciPy's bounded-variable least squares, another algorithm, on the same problem."""
    rng = np.random.default_rng(seed)
    M, target = rng.normal(size=(15, 6)), 5.0 * rng.normal(size=15)
    bound = np.full(6, 0.3)
    program = QuadraticProgram(M.T @ M, -target @ M, np.eye(6), -bound, bound, np.full(6, np.inf))
    truth = lsq_linear(M, target, (-bound, bound), method="bvls", tol=1e-14).x
    np.testing.assert_allclose(solve_qp(program, np.zeros(6, int)).v, truth, atol=1e-10)
