"""The attitude problem: its numbers arrive where they belong, and one library serves them all."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simsat.control.ground import attitude
from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft, nominal
from simsat.control.model.dynamics import build_dynamics, rk4_step
from simsat.control.model.ramp import mean_ramped_torque
from simsat.control.nmpc.cost import Weights
from simsat.control.nmpc.planner import NmpcSettings, build_attitude_ocp, torque_scale
from simsat.control.solver import SolverSettings, solver_of
from simsat.control.solver.compiled.solver import CompiledSolver
from simsat.control.solver.ocp import Ocp
from tests.compiler_cases import needs_compiler
from tests.ocp_cases import THREE_WHEELS, TWO_WHEELS, random_state, spacecraft

FULL = np.array([[1.5, 0.06, -0.05], [0.06, 1.6, 0.07], [-0.05, 0.07, 1.2]])  # kg m^2
WITH_PRODUCTS = replace(TWO_WHEELS, J=FULL)
UNEQUAL = replace(
    spacecraft(attitude.normalized(np.array([[1.0, 0.2, 0.1], [-0.3, 1.0, 0.4]])).T),
    J=FULL,
    Js=np.array([1e-3, 3e-3]),
    torque_max=np.array([0.05, np.inf]),
    torque_rate_max=np.array([np.inf, 0.3]),
    viscous=np.array([2e-6, 0.0]),
    coulomb=np.array([1e-3, 2e-3]),
)
WEIGHTS = Weights(2.0, 30.0, 0.7, 1e-3, 0.0, 5.0)


@pytest.mark.parametrize("craft", [TWO_WHEELS, WITH_PRODUCTS, THREE_WHEELS, UNEQUAL])
@pytest.mark.parametrize("friction", [False, True])
def test_the_stage_is_a_step_of_the_spacecrafts_dynamics(craft: Spacecraft, friction: bool) -> None:
    """By the CasADi function with the numbers written in."""
    problem = build_attitude_ocp(craft, NmpcSettings(period=0.3, friction=friction))
    rng, m = np.random.default_rng(0), craft.wheels
    x, u, tau_d = random_state(rng, craft), rng.uniform(-0.05, 0.05, m), rng.normal(size=3)
    derivative, mean = (
        build_dynamics(craft, friction),
        mean_ramped_torque(craft, u, x[7 + m :], 0.3),
    )
    moved = rk4_step(lambda s: derivative(s, mean, tau_d), x[: 7 + m], 0.3)
    expected = np.concatenate([np.asarray(moved).ravel(), u])
    following = np.asarray(problem.evaluate(x, u, tau_d)[0]).ravel()
    np.testing.assert_allclose(following, expected, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("craft", [TWO_WHEELS, WITH_PRODUCTS, THREE_WHEELS, UNEQUAL])
@pytest.mark.parametrize("weights", [Weights(), WEIGHTS])
def test_the_stage_costs_what_the_weights_say(craft: Spacecraft, weights: Weights) -> None:
    """The formula of `cost.py`, written out."""
    settings = NmpcSettings(weights=weights)
    problem, scale = build_attitude_ocp(craft, settings), torque_scale(craft, settings)
    rng, m = np.random.default_rng(1), craft.wheels
    x, u = random_state(rng, craft), rng.uniform(-0.05, 0.05, m)
    phi, n = 2.0 * x[1:4], craft.loop_normal
    along = np.zeros(3) if n is None else (n @ phi) * n
    state = (
        weights.attitude * np.sum((phi - along) ** 2)
        + weights.unactuated * np.sum(along**2)
        + weights.rate * np.sum(x[4:7] ** 2)
    )
    effort, increment = u / scale, (u - x[7 + m :]) / scale
    inputs = weights.effort * np.sum(effort**2) + weights.increment * np.sum(increment**2)
    residual = np.asarray(problem.evaluate(x, u, np.zeros(3))[1])
    end = np.asarray(problem.evaluate_end(x, np.zeros(3)))
    assert 0.5 * np.sum(residual**2) == pytest.approx(state + inputs, rel=1e-12)
    assert 0.5 * np.sum(end**2) == pytest.approx(weights.terminal * state, rel=1e-12)


def ocp(craft: Spacecraft = WITH_PRODUCTS, horizon: int = 5, **settings: Any) -> Ocp:
    return build_attitude_ocp(craft, NmpcSettings(horizon=horizon, **settings))


SAME: dict[str, Callable[[], Ocp]] = {
    "diagonal inertia": lambda: ocp(TWO_WHEELS),
    "inertia": lambda: ocp(nominal(WITH_PRODUCTS, np.array([1.1, 0.9, 1.2]), 0.5)),
    "rotors": lambda: ocp(replace(WITH_PRODUCTS, Js=np.array([1e-3, 2e-3]))),
    "torque": lambda: ocp(replace(WITH_PRODUCTS, torque_max=np.array([0.02, 0.03]))),
    "rate": lambda: ocp(replace(WITH_PRODUCTS, torque_rate_max=np.full(2, 1.0))),
    "speed": lambda: ocp(replace(WITH_PRODUCTS, speed_max=np.full(2, 300.0))),
    "weights": lambda: ocp(weights=WEIGHTS),
    "period": lambda: ocp(period=0.25),
}
OTHERS: dict[str, Callable[[], Ocp]] = {
    "axes": lambda: ocp(replace(WITH_PRODUCTS, A=UNEQUAL.A)),
    "friction": lambda: ocp(replace(WITH_PRODUCTS, coulomb=np.full(2, 1e-3)), friction=True),
    "no rate limit": lambda: ocp(replace(WITH_PRODUCTS, torque_rate_max=np.full(2, np.inf))),
}


@pytest.mark.parametrize("change", SAME)
def test_numbers_are_no_part_of_the_structure(change: str) -> None:
    plain, changed = ocp(), SAME[change]()
    assert changed.stage is plain.stage
    assert len(changed.limits.lower) == len(plain.limits.lower)


@pytest.mark.parametrize("change", OTHERS)
def test_what_is_left_out_is_part_of_the_structure(change: str) -> None:
    assert OTHERS[change]().stage is not ocp().stage


@needs_compiler
def test_a_study_of_inertia_and_weights_compiles_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sixteen problems, with products of inertia and without, are one structure. (Nothing else has
    this horizon.)"""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    factors = np.array([1.1, 0.9, 1.2])

    for mismatch in (0.0, 0.5, 1.0, 2.0):
        craft = nominal(WITH_PRODUCTS, factors, mismatch)
        for rate in (0.0, 0.5, 1.0, 2.0):
            solver = solver_of(ocp(craft, 7, weights=Weights(rate=rate)), "auto")
            assert isinstance(solver, CompiledSolver)
    assert len(list((tmp_path / "simsat").glob("*.so"))) == 1


@needs_compiler
def test_problems_that_share_a_library_keep_their_numbers() -> None:
    """Solved in turn, each agrees with its own interpreted solver, whatever came between."""
    problems = [SAME[change]() for change in ("inertia", "weights", "period", "torque", "rate")]
    x0, guess, p = random_state(np.random.default_rng(2)), np.zeros((5, 2)), np.zeros((6, 3))

    def solved(problem: Ocp, backend: str) -> Array:
        return solver_of(problem, backend).solve(x0, guess, p, SolverSettings()).u

    first, again = ([solved(problem, "auto") for problem in problems] for _ in range(2))
    for problem, u, v in zip(problems, first, again, strict=True):
        np.testing.assert_array_equal(u, v)
        np.testing.assert_allclose(u, solved(problem, "interpreted"), rtol=0.0, atol=1e-9)  # Nm
    assert len({u.tobytes() for u in first}) == len(first)
