from collections.abc import Sequence

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import error_angle, from_axis_angle
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.guidance.minimum_time import (
    BoundaryValues,
    build_minimum_time,
    solve_minimum_time,
)
from simsat.control.learned.guidance.terminal import (
    TerminalConditions,
    TerminalProblem,
    TerminalSolution,
    solve_terminal,
)
from simsat.control.learned.prediction.propagation import build_propagator
from simsat.control.model.momentum import MomentumModel
from tests.learned_cases import SKEWED, TARGET, TRUE_J, craft, flown, ramped

PERIOD = 0.5
LIMIT = np.full(2, 0.05)


def rest(
    spacecraft: Spacecraft, axis: Sequence[float] = (0.48, -0.64, 0.6), angle_deg: float = 75.0
) -> tuple[MomentumModel, Array]:
    q = from_axis_angle(np.array(axis), np.deg2rad(angle_deg))
    model = MomentumModel(spacecraft, TRUE_J, np.array([0.0, 0.0, 0.0]))
    return model, np.concatenate([q, np.zeros(2 * spacecraft.wheels)])


def solved(
    model: MomentumModel,
    x0: Array,
    guess: Array,
    conditions: TerminalConditions = TerminalConditions.FULL,
    iterations: int = 6,
) -> TerminalSolution:
    """The plan to rest in TARGET within 0.05 Nm."""
    spacecraft = model.spacecraft
    problem = TerminalProblem(
        build_propagator(spacecraft),
        model,
        x0,
        TARGET,
        np.full(spacecraft.wheels, 0.05),
        PERIOD,
        conditions,
    )
    return solve_terminal(problem, guess, iterations)


def arrival(spacecraft: Spacecraft, torque: Array, q0: Array) -> tuple[Array, Array]:
    """Attitude and rate that SciPy finds at the end of a plan, motors ramping."""
    t = np.array([0.0, len(torque) * PERIOD])
    m = spacecraft.wheels
    f = flown(spacecraft, ramped(torque, np.zeros(m), 0.4, PERIOD), t, q0, rtol=1e-7)
    return f.q[-1], f.omega[-1]


@pytest.mark.parametrize("A", [None, SKEWED])
def test_the_plan_arrives_at_rest_within_the_limits(A: Array | None) -> None:
    spacecraft = craft(A=A)
    model, x0 = rest(spacecraft)
    values = BoundaryValues(x0[:4], x0[4:6], TARGET, LIMIT)
    found = solve_minimum_time(build_minimum_time(spacecraft), model, values, 0)
    assert found is not None
    periods = int(np.ceil((found.duration + 0.25) / PERIOD))
    guess = np.vstack([found.on_grid(periods, PERIOD), np.zeros(2)])
    plan = solved(model, x0, guess, iterations=12)
    assert plan.terminal_error < 1e-4
    assert np.all(np.abs(plan.torque) <= 0.05)
    assert np.all(plan.torque[-1] == 0.0)
    q, omega = arrival(spacecraft, plan.torque, x0[:4])
    assert error_angle(q, TARGET) < 2e-4  # rad
    assert np.max(np.abs(omega)) < 2e-4  # rad/s


def test_three_wheels_arrive_from_no_guess_at_all() -> None:
    spacecraft = craft(A=np.eye(3))
    model, x0 = rest(spacecraft)
    plan = solved(model, x0, np.zeros((40, 3)), iterations=15)
    q, omega = arrival(spacecraft, plan.torque, x0[:4])
    assert error_angle(q, TARGET) < 1e-4
    assert np.max(np.abs(omega)) < 1e-4


def test_without_the_condition_along_n_only_the_wheels_plane_arrives() -> None:
    spacecraft = craft()
    model, x0 = rest(spacecraft, (0.0, 0.3, 1.0), 2.0)
    plan = solved(model, x0, np.zeros((6, 2)), TerminalConditions.ACTUATED)
    q, omega = arrival(spacecraft, plan.torque, x0[:4])
    assert np.max(np.abs(omega)) < 1e-6
    assert np.max(np.abs(q[1:3])) < 1e-6
    assert model.tilt is not None
    before = model.tilt @ (2.0 * x0[1:4])
    assert model.tilt @ (2.0 * q[1:]) == pytest.approx(before, abs=3e-4)  # moves by e^2 / 2


def test_near_the_goal_it_is_the_least_squares_law_of_a_double_integrator() -> None:
    spacecraft = craft(A=np.eye(3))
    phi = np.array([1e-4, -2e-4, 1.5e-4])  # rad: far from every limit
    model, x0 = rest(spacecraft, phi.tolist(), np.rad2deg(np.linalg.norm(phi)))
    K = 6
    plan = solved(model, x0, np.zeros((K, 3)))
    moves = PERIOD * (np.arange(K - 1, 0, -1) - 0.5) * PERIOD + PERIOD * PERIOD
    C = np.vstack([np.full(K - 1, PERIOD), moves - PERIOD * PERIOD + PERIOD * PERIOD])
    least = np.linalg.pinv(C) @ np.array([0.0, 1.0])  # acceleration for one unit of angle, at rest
    J_hub = np.linalg.inv(model.J_hub_inverse)
    expected = np.outer(least, J_hub @ phi)
    assert np.max(np.abs(plan.torque[:-1] - expected)) < 0.1 * np.max(np.abs(expected))


def test_one_period_too_few_is_admitted() -> None:
    spacecraft = craft()
    model, x0 = rest(spacecraft)
    plan = solved(model, x0, np.zeros((8, 2)))
    assert plan.terminal_error > 0.1
    assert np.all(np.abs(plan.torque) <= 0.05)
