"""Plans in C and interpreted, with a network and without, against each other and against SciPy."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.prediction.compiled import CompiledPropagator
from simsat.control.learned.prediction.interpreted import InterpretedPropagator
from simsat.control.learned.prediction.propagation import build_propagator
from simsat.control.model.appendage import AppendageNetwork
from simsat.control.model.momentum import MomentumModel, spin_momentum
from tests.appendage_cases import random_network
from tests.compiler_cases import needs_compiler
from tests.learned_cases import SKEWED, TARGET, TRUE_J, craft, flown, matrix, ramped

Q = np.array([0.8, -0.36, 0.48, 0.0])
GOAL = np.array([0.99, 0.1, -0.05, 0.08]) / np.linalg.norm([0.99, 0.1, -0.05, 0.08])
PERIOD = 0.5

Case = tuple[Spacecraft, MomentumModel, Array, Array, Array, Array, Array]


def case(A: Array | None = None, biased: bool = False, K: int = 10) -> Case:
    spacecraft = craft(A=A)
    m = spacecraft.wheels
    speed0 = np.array([120.0, -70.0, 90.0, 0.0])[:m] if biased else np.zeros(m)
    omega0 = np.array([0.03, -0.02, 0.04]) if biased else np.array([0.0, 0.0, 0.0])
    plan = np.random.default_rng(2).uniform(-0.05, 0.05, (K, m))
    before = np.array([0.02, -0.01, 0.03, 0.0])[:m]
    h_N = matrix(Q) @ spacecraft.angular_momentum(omega0, speed0)
    x0 = np.concatenate([Q, spin_momentum(spacecraft, omega0, speed0), before])
    return spacecraft, MomentumModel(spacecraft, TRUE_J, h_N), x0, plan, omega0, speed0, before


def even(plan: Array) -> Array:
    """Intervals of one period."""
    return np.full(len(plan), PERIOD)


@pytest.mark.parametrize("A", [None, SKEWED])
@pytest.mark.parametrize("biased", [False, True])
@pytest.mark.parametrize("backend", ["auto", "interpreted"])
def test_it_ends_where_the_full_equations_end(A: Array | None, biased: bool, backend: str) -> None:
    """Intervals of a period, of half of one and of two."""
    spacecraft, model, x0, plan, omega0, speed0, before = case(A, biased)
    lengths = PERIOD * np.array([1.0, 1.0, 0.5, 0.5, 1.0, 2.0, 1.0, 0.5, 1.0, 1.0])
    parts = np.rint(2.0 * lengths / PERIOD).astype(int)  # half periods, the ramp in the first
    torque = ramped(np.repeat(plan, parts, axis=0), before, 0.4, PERIOD / 2.0)
    t = np.concatenate([[0.0], np.cumsum(lengths)])
    f = flown(spacecraft, torque, t, Q, omega0, speed0)
    propagator = build_propagator(spacecraft, backend=backend)
    end, _, x = propagator.linearize(model, x0, plan, lengths, GOAL)
    assert np.max(np.abs(x[:, :4] - f.q)) < (3e-4 if biased else 3e-6)
    p = spin_momentum(spacecraft, f.omega, f.speed)
    assert np.max(np.abs(x[:, 4:6] - p)) < 1e-7  # Nms
    apart = matrix(GOAL).T @ matrix(f.q[-1])
    vector = 0.5 * np.array(
        [apart[2, 1] - apart[1, 2], apart[0, 2] - apart[2, 0], apart[1, 0] - apart[0, 1]]
    )
    sine = vector / np.sqrt(1.0 + np.trace(apart))  # q_v of a rotation matrix, q_0 > 0
    assert np.max(np.abs(end[:3] - 2.0 * sine)) < 6e-4


def decaying(network: AppendageNetwork) -> AppendageNetwork:
    """Weights at random would blow up."""
    return replace(network, output_scale=0.01 * network.output_scale)


NETWORKS = (
    None,
    decaying(random_network()),
    decaying(random_network(width=0)),
    decaying(random_network(wheels=3, gates=0)),
)


@needs_compiler
@pytest.mark.parametrize("network", NETWORKS, ids=["none", "two wheels", "linear", "three wheels"])
@pytest.mark.parametrize("K", [1, 7, 300])
def test_in_c_it_is_what_the_interpreter_says(network: AppendageNetwork | None, K: int) -> None:
    """To round-off, which 300 intervals let grow."""
    A = None if network is None or network.wheels == 2 else np.eye(3)
    spacecraft, model, x0, plan, *_ = case(A, biased=True, K=K)
    if network is not None:
        rng = np.random.default_rng(3)
        x0 = np.r_[x0, 1e-3 * rng.normal(size=6), 0.01 * rng.normal(size=spacecraft.wheels)]
    lengths = np.random.default_rng(4).uniform(0.05, 0.5, K)  # some ramps don't end within them
    answers = []
    for backend, kind in (("auto", CompiledPropagator), ("interpreted", InterpretedPropagator)):
        propagator = build_propagator(spacecraft, network, backend)
        assert isinstance(propagator, kind)
        end, slope, x = propagator.linearize(model, x0, plan, lengths, GOAL)
        answers.append((end, slope, x, propagator.end(model, x0, plan, lengths, GOAL)))
    for compiled, interpreted in zip(*answers, strict=True):
        size = 1.0 + np.abs(interpreted).max()
        assert np.abs(compiled - interpreted).max() < 1e-12 * size
    assert np.abs(answers[0][3] - answers[0][0]).max() < 1e-12


@pytest.mark.parametrize("backend", ["auto", "interpreted"])
def test_the_slope_is_the_derivative(backend: str) -> None:
    spacecraft, model, x0, plan, *_ = case(biased=True)
    propagator, lengths = build_propagator(spacecraft, backend=backend), even(plan)
    _, slope, _ = propagator.linearize(model, x0, plan, lengths, GOAL)
    for k in (0, 7, 13, 19):
        step = np.zeros(plan.size)
        step[k] = 1e-6
        more, less = (
            propagator.end(model, x0, plan + sign * step.reshape(plan.shape), lengths, GOAL)
            for sign in (1.0, -1.0)
        )
        assert np.max(np.abs((more - less) / 2e-6 - slope[:, k])) < 1e-5


def test_a_plan_in_two_pieces_ends_where_it_does_in_one() -> None:
    spacecraft, model, x0, plan, *_ = case(biased=True, K=90)
    propagator = build_propagator(spacecraft)
    _, _, x = propagator.linearize(model, x0, plan, even(plan), GOAL)
    end = propagator.end(model, x[33], plan[33:], even(plan[33:]), GOAL)
    assert np.abs(end - propagator.end(model, x0, plan, even(plan), GOAL)).max() < 1e-12


def test_at_rest_in_the_goal_nothing_is_left_over() -> None:
    spacecraft = craft()
    x0 = np.concatenate([TARGET, np.zeros(4)])
    model = MomentumModel(spacecraft, TRUE_J, np.array([0.0, 0.0, 0.0]))
    still = np.zeros((5, 2))
    for sign in (1.0, -1.0):
        end = build_propagator(spacecraft).end(model, x0, still, even(still), sign * TARGET)
        assert np.all(end == 0.0)


@needs_compiler
def test_another_craft_with_as_many_wheels_needs_no_other_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    build_propagator(craft())
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    build_propagator(craft(A=SKEWED, J=2.0 * TRUE_J, rate=0.1))
    assert not list(tmp_path.rglob("*.so"))


def test_plans_on_several_threads_do_not_meet() -> None:
    """The library has no memory of its own."""
    spacecraft, model, x0, plan, *_ = case(biased=True, K=300)
    propagator, plans = build_propagator(spacecraft), [plan * share for share in (1.0, 0.5, -1.0)]

    def end(one: Array) -> Array:
        return propagator.linearize(model, x0, one, even(one), GOAL)[1]

    alone = [end(one) for one in plans]
    with ThreadPoolExecutor(3) as pool:
        for _ in range(20):
            for together, expected in zip(pool.map(end, plans), alone, strict=True):
                assert np.array_equal(together, expected)
