"""The solver: against Riccati, IPOPT and autodiff, compiled against interpreted, and its ends."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.solver import (
    Solution,
    SolverSettings,
    SolverStatus,
    roll_out,
    solve_ocp,
    solver_of,
)
from simsat.control.solver.compiled.compiler import find_compiler
from simsat.control.solver.compiled.solver import CompiledSolver
from simsat.control.solver.interpreted import InterpretedSolver
from simsat.control.solver.ocp import Limits, Ocp, no_limits
from tests.ocp_cases import (
    THREE_WHEELS,
    TWO_WHEELS,
    attitude_ocp,
    double_integrator,
    ipopt_objective,
    random_state,
)

INTERPRETED = SolverSettings(backend="interpreted")
TIGHT = replace(INTERPRETED, tolerance=1e-12)
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


@pytest.fixture(scope="module")
def ocp() -> Ocp:
    return attitude_ocp()


def warm_start(ocp: Ocp, rng: np.random.Generator) -> tuple[Array, Array]:
    return random_state(rng), rng.uniform(-0.05, 0.05, (ocp.N, ocp.nu))


def single_shooting_gradient(ocp: Ocp, x0: Array, u: Array, p: Array) -> Array:
    """Derivative of the cost by all inputs, by CasADi's reverse mode through the roll-out."""
    U = ca.MX.sym("U", ocp.nu, ocp.N)
    x, cost = ca.MX(x0), 0.0
    for k in range(ocp.N):
        x_next, r = ocp.evaluate(x, U[:, k], p)
        cost += 0.5 * ca.sumsqr(r)
        x = x_next
    cost += 0.5 * ca.sumsqr(ocp.evaluate_end(x, p))
    return np.array(ca.Function("g", [U], [ca.gradient(cost, U)])(u.T)).T


def test_a_linear_quadratic_problem_is_solved_in_one_step_by_riccati() -> None:
    """Against the discrete Riccati recursion, written here."""
    ocp = double_integrator(no_limits(2, 1))
    A, B = np.array([[1.0, 0.2], [0.0, 1.0]]), np.array([[0.02], [0.2]])
    Q, R = np.diag([1.0, 0.25]), np.array([[0.01]])
    P = 9.0 * Q
    for _ in range(ocp.N):
        K = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
        P = Q + A.T @ P @ (A - B @ K)
    x0 = np.array([1.0, -0.4])
    solution = solve_ocp(ocp, x0, np.zeros((ocp.N, 1)), np.zeros(1), INTERPRETED)
    assert solution.u[0] == pytest.approx(-K @ x0, rel=1e-6)
    assert solution.objective == pytest.approx(0.5 * x0 @ P @ x0, rel=1e-9)
    assert solution.status is SolverStatus.SOLVED
    assert solution.iterations == 2  # the second only finds nothing left to gain


@pytest.mark.parametrize("seed", range(6))
def test_the_optimum_is_ipopts(ocp: Ocp, seed: int) -> None:
    """Same state, same guess; wheel speeds far from their limits and (seed 5) beyond them."""
    rng = np.random.default_rng(seed)
    x0, guess = warm_start(ocp, rng)
    if seed == 5:
        x0[7:9] = [640.0, -660.0]  # rad/s; the limit is 628.3
    tau_d = 1e-3 * rng.normal(size=3)
    ours = solve_ocp(ocp, x0, guess, tau_d, INTERPRETED)
    theirs = ipopt_objective(ocp, x0, ours.u, tau_d)
    assert ours.objective == pytest.approx(theirs, rel=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_reported_stationarity_is_the_lagrangians_gradient(ocp: Ocp, seed: int) -> None:
    """By autodiff; where an input is on its bound the gradient may push against it, no more."""
    x0, guess = warm_start(ocp, np.random.default_rng(seed))
    solution = solve_ocp(ocp, x0, guess, np.zeros(3), TIGHT)
    gradient = single_shooting_gradient(ocp, x0, solution.u, np.zeros(3))
    free = np.abs(solution.u) < 0.05 - 1e-9
    assert np.max(np.abs(gradient[free]), initial=0.0) <= solution.kkt.stationarity + 1e-9
    assert np.all(gradient[~free] * solution.u[~free] <= 0.0)
    assert solution.kkt.stationarity < 1e-6 * np.max(np.abs(gradient))
    assert solution.kkt.feasibility < 1e-12
    assert solution.kkt.complementarity < 1e-9


def test_residuals_show_an_unfinished_solution(ocp: Ocp) -> None:
    x0, guess = warm_start(ocp, np.random.default_rng(0))
    one_step = replace(INTERPRETED, max_iterations=1)
    unfinished = solve_ocp(ocp, x0, guess, np.zeros(3), one_step)
    finished = solve_ocp(ocp, x0, guess, np.zeros(3), TIGHT)
    assert unfinished.status is SolverStatus.ITERATION_LIMIT
    assert unfinished.kkt.stationarity > 1e3 * finished.kkt.stationarity
    assert unfinished.kkt.feasibility < 1e-12  # hard limits hold after any step
    assert unfinished.objective > finished.objective


def test_states_are_the_inputs_roll_out(ocp: Ocp) -> None:
    x0, guess = warm_start(ocp, np.random.default_rng(1))
    solution = solve_ocp(ocp, x0, guess, np.zeros(3), INTERPRETED)
    x, cost = roll_out(ocp, x0, solution.u, np.zeros(3), INTERPRETED)
    np.testing.assert_array_equal(solution.x, x)
    assert solution.objective == cost
    for k in range(ocp.N):
        following = np.array(ocp.evaluate(x[k], solution.u[k], np.zeros(3))[0]).ravel()
        np.testing.assert_allclose(x[k + 1], following, rtol=1e-12, atol=1e-14)


def test_fourth_powers_converge() -> None:
    """A cost of squared squares is flat at its optimum; the stationarity still vanishes."""
    ocp = double_integrator(power=2)
    x0, p = np.array([1.0, 0.3]), np.zeros(1)
    settings = replace(TIGHT, max_iterations=60)
    solution = solve_ocp(ocp, x0, np.zeros((ocp.N, 1)), p, settings)
    gradient = single_shooting_gradient(ocp, x0, solution.u, p)
    free = np.abs(solution.u) < 1.0 - 1e-9
    assert solution.status is SolverStatus.SOLVED
    assert np.max(np.abs(gradient[free])) < 1e-6
    assert solution.objective == pytest.approx(ipopt_objective(ocp, x0, solution.u, p), rel=1e-6)


def test_parameters_may_differ_from_stage_to_stage() -> None:
    """A push p_k on one stage alone is the same as that much input there."""
    ocp = double_integrator(no_limits(2, 1))
    x0, p = np.array([1.0, 0.0]), np.zeros((ocp.N + 1, 1))
    p[3] = 0.7
    still, _ = roll_out(ocp, x0, np.zeros((ocp.N, 1)), p, INTERPRETED)
    pushed, _ = roll_out(ocp, x0, p[:-1], np.zeros(1), INTERPRETED)
    np.testing.assert_allclose(still, pushed, atol=1e-15)


def test_soft_rows_give_way_and_hard_rows_do_not() -> None:
    """A speed limit that the start breaks, with inputs too weak to mend it at once."""
    limits = Limits(
        Cx=np.array([[0.0, 0.0], [0.0, 1.0]]),
        Cu=np.array([[1.0], [0.0]]),
        lower=-np.array([1.0, 0.5]),
        upper=np.array([1.0, 0.5]),
        softness=np.array([np.inf, 30.0]),
    )
    ocp = double_integrator(limits)
    x0, p = np.array([-3.0, 1.2]), np.zeros(1)
    solution = solve_ocp(ocp, x0, np.zeros((ocp.N, 1)), p, INTERPRETED)
    assert solution.status is SolverStatus.SOLVED
    assert np.max(np.abs(solution.u)) <= 1.0 + 1e-12
    assert solution.x[1, 1] > 0.9
    assert np.all(solution.x[5:, 1] < 0.5 + 1e-9)
    assert solution.objective == pytest.approx(ipopt_objective(ocp, x0, solution.u, p), rel=1e-6)


def test_numbers_that_are_not_finite_are_a_failure(ocp: Ocp) -> None:
    x0, guess = warm_start(ocp, np.random.default_rng(0))
    x0[4] = np.nan
    for settings in (INTERPRETED, SolverSettings()):
        solution = solve_ocp(ocp, x0, guess, np.zeros(3), settings)
        assert solution.status is SolverStatus.FAILED


def assert_same(a: Solution, b: Solution) -> None:
    assert (a.status, a.iterations) == (b.status, b.iterations)
    np.testing.assert_allclose(a.u, b.u, rtol=0.0, atol=1e-9)  # Nm
    np.testing.assert_allclose(a.x, b.x, rtol=1e-9, atol=1e-9)
    assert a.objective == pytest.approx(b.objective, rel=1e-12)
    assert a.kkt.stationarity == pytest.approx(b.kkt.stationarity, rel=1e-3, abs=1e-7)
    assert a.kkt.feasibility == pytest.approx(b.kkt.feasibility, abs=1e-12)


@needs_compiler
@pytest.mark.parametrize("seed", range(12))
def test_compiled_and_interpreted_agree(ocp: Ocp, seed: int) -> None:
    """Warm and cold starts, limits of speed and (last seeds) saddles, to 1e-9 Nm."""
    rng = np.random.default_rng(seed)
    x0, guess = warm_start(ocp, rng)
    if seed % 3 == 1:
        x0[4:], guess = 0.0, np.zeros_like(guess)
    if seed % 3 == 2:
        x0[7:9] = rng.uniform(580.0, 680.0, 2)
    if seed > 9:
        x0 = np.array([np.cos(0.6), 0.0, 0.0, np.sin(0.6), *np.zeros(7)])
    compiled, interpreted = solver_of(ocp, "auto"), solver_of(ocp, "interpreted")
    assert isinstance(compiled, CompiledSolver)
    assert isinstance(interpreted, InterpretedSolver)
    p = np.tile(1e-3 * rng.normal(size=3), (ocp.N + 1, 1))
    settings = SolverSettings()
    assert_same(compiled.solve(x0, guess, p, settings), interpreted.solve(x0, guess, p, settings))
    np.testing.assert_allclose(
        compiled.roll_out(x0, guess, p)[0], interpreted.roll_out(x0, guess, p)[0], atol=1e-9
    )


@needs_compiler
def test_compiled_and_interpreted_agree_on_every_kind_of_row() -> None:
    """Hard torque and torque-rate rows, soft speed and body-rate rows, three wheels, friction."""
    slow = replace(THREE_WHEELS, torque_rate_max=np.full(3, 0.05), coulomb=np.full(3, 1e-3))
    ocp = attitude_ocp(slow, horizon=10, keep_rate_below_deg_s=8.0, friction=True)
    rng = np.random.default_rng(5)
    p = np.zeros((ocp.N + 1, 3))
    for _ in range(5):
        x0 = random_state(rng, slow)
        x0[7:10] = 600.0
        compiled, interpreted = (
            solver_of(ocp, backend).solve(x0, np.zeros((10, 3)), p, SolverSettings())
            for backend in ("auto", "interpreted")
        )
        assert_same(compiled, interpreted)


def test_a_saddle_is_reported_as_what_it_is() -> None:
    """At rest with an error about the unactuated axis alone, no torque is a stationary point."""
    ocp = attitude_ocp(TWO_WHEELS)
    x0 = np.array([np.cos(0.6), 0.0, 0.0, np.sin(0.6), *np.zeros(7)])
    solution = solve_ocp(ocp, x0, np.zeros((ocp.N, 2)), np.zeros(3), INTERPRETED)
    np.testing.assert_array_equal(solution.u, 0.0)
    assert solution.kkt.stationarity == pytest.approx(0.0, abs=1e-9)
