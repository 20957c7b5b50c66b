"""A planner with an objective of the user's own, against the baseline's and IPOPT."""

import casadi as ca
import numpy as np

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array, Symbol
from simsat.control.nmpc.cost import Weights
from simsat.control.nmpc.guess import Guess, shapes
from simsat.control.nmpc.own_objective import build_ocp_for
from simsat.control.nmpc.planner import NmpcSettings, build_attitude_ocp
from simsat.control.solver import SolverSettings, roll_out, solve_ocp
from simsat.control.solver.ocp import Ocp
from tests.ocp_cases import TWO_WHEELS, ipopt_objective, random_state

WEIGHTS = Weights()
INTERPRETED = SolverSettings(backend="interpreted")
SIZES = (1.0, 0.5, 0.25)
SHORT = NmpcSettings(horizon=8, solver=INTERPRETED)


def quadratic(q: Symbol, omega: Symbol, effort: Symbol, increment: Symbol) -> tuple[Symbol, Symbol]:
    """The paper's, written once more as a user would."""
    phi, n = 2 * q[1:4], ca.DM([0, 0, 1])
    along = ca.dot(n, phi)
    parts = [
        np.sqrt(WEIGHTS.attitude) * (phi - along * n),
        np.sqrt(WEIGHTS.unactuated) * along,
        np.sqrt(WEIGHTS.rate) * omega,
    ]
    inputs = [np.sqrt(WEIGHTS.effort) * effort, np.sqrt(WEIGHTS.increment) * increment]
    state = np.sqrt(2) * ca.vertcat(*parts)
    return ca.vertcat(state, np.sqrt(2) * ca.vertcat(*inputs)), np.sqrt(WEIGHTS.terminal) * state


def quartic(q: Symbol, omega: Symbol, effort: Symbol, increment: Symbol) -> tuple[Symbol, Symbol]:
    state = ca.vertcat(ca.dot(q[1:3], q[1:3]), 7 * q[3], ca.dot(omega, omega), 0.1 * q[1:3])
    return ca.vertcat(state, 0.1 * effort, 0.03 * increment), 3 * state


def test_the_paper_s_objective_as_one_s_own_gives_the_paper_s_costs() -> None:
    rng = np.random.default_rng(1)
    own = build_ocp_for(quadratic, TWO_WHEELS, SHORT)
    theirs = build_attitude_ocp(TWO_WHEELS, SHORT)
    for _ in range(5):
        x0, u = random_state(rng), rng.uniform(-0.05, 0.05, (8, 2))
        states, cost = roll_out(own, x0, u, np.zeros(3), INTERPRETED)
        expected_states, expected = roll_out(theirs, x0, u, np.zeros(3), INTERPRETED)
        np.testing.assert_allclose(states, expected_states, atol=1e-14)
        np.testing.assert_allclose(cost, expected, rtol=1e-12)


def test_the_optimum_of_fourth_powers_is_ipopt_s() -> None:
    rng = np.random.default_rng(2)
    ocp = build_ocp_for(quartic, TWO_WHEELS, SHORT)
    for _ in range(2):
        x0, guess = random_state(rng), np.zeros((8, 2))
        ours = solve_ocp(ocp, x0, guess, np.zeros(3), INTERPRETED)
        np.testing.assert_allclose(
            ours.objective, ipopt_objective(ocp, x0, guess, np.zeros(3)), rtol=1e-6
        )


def homogeneous(
    q: Symbol, omega: Symbol, effort: Symbol, increment: Symbol
) -> tuple[Symbol, Symbol]:
    """Fourth powers of all but the angle about the axis that no wheel can push; as large as an
    angle there of 0.05 deg asks for, or they drown in the solver's tolerance."""
    phi = 2 * q[1:4]
    state = 1e3 * ca.vertcat(ca.dot(phi[:2], phi[:2]), 10 * phi[2], ca.dot(omega, omega))
    return ca.vertcat(state, 100 * ca.dot(effort, effort), 0.0 * increment), 3 * state


def best_of_loops(ocp: Ocp, x0: Array) -> tuple[float, float]:
    """The best cost from loops either way round, and the cost of no torque at all."""
    p, limit = np.zeros(3), TWO_WHEELS.torque_max
    loops = shapes(TWO_WHEELS, limit, x0[:4], ocp.N, 0.5)
    guesses = [size * loops[turn] for turn in (Guess.LOOP_LEFT, Guess.LOOP_RIGHT) for size in SIZES]
    costs = [solve_ocp(ocp, x0, guess, p, INTERPRETED).objective for guess in guesses]
    return min(costs), roll_out(ocp, x0, 0.0 * guesses[0], p, INTERPRETED)[1]


def test_fourth_powers_pay_for_a_loop_where_squares_lie_still() -> None:
    """The dead zone of every quadratic cost (Mueller and Worthmann 2017), 0.05 deg from the
    target about the unactuated axis, and none of the homogeneous one's (Coron et al. 2020)."""
    settings = NmpcSettings(solver=INTERPRETED)
    q = attitude.from_axis_angle(np.array([0.0, 0.0, 1.0]), np.deg2rad(0.05))
    x0 = np.concatenate([q, np.zeros(7)])
    best, still = best_of_loops(build_attitude_ocp(TWO_WHEELS, settings), x0)
    assert best > (1.0 - 1e-6) * still
    best, still = best_of_loops(build_ocp_for(homogeneous, TWO_WHEELS, settings), x0)
    assert best < 0.7 * still
