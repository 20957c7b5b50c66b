import numpy as np
import pytest

from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.learned.prediction.propagation import LENGTHS, build_propagators, propagate
from simsat.control.model.momentum import MomentumModel, spin_momentum
from tests.learned_cases import SKEWED, TARGET, TRUE_J, craft, flown, matrix, ramped, times

Q = np.array([0.8, -0.36, 0.48, 0.0])
GOAL = np.array([0.99, 0.1, -0.05, 0.08]) / np.linalg.norm([0.99, 0.1, -0.05, 0.08])
PERIOD = 0.5


Case = tuple[Spacecraft, MomentumModel, Array, Array, Array, Array, Array]


def case(A: Array | None = None, biased: bool = False, K: int = 10) -> Case:
    spacecraft = craft(A=A)
    speed0 = np.array([120.0, -70.0]) if biased else np.zeros(2)
    omega0 = np.array([0.03, -0.02, 0.04]) if biased else np.zeros(3)
    plan = np.random.default_rng(2).uniform(-0.05, 0.05, (K, 2))
    before = np.array([0.02, -0.01])
    h_N = matrix(Q) @ spacecraft.angular_momentum(omega0, speed0)
    x0 = np.concatenate([Q, spin_momentum(spacecraft, omega0, speed0), before])
    return spacecraft, MomentumModel(spacecraft, TRUE_J, h_N), x0, plan, omega0, speed0, before


@pytest.mark.parametrize("A", [None, SKEWED])
@pytest.mark.parametrize("biased", [False, True])
def test_it_ends_where_the_full_equations_end(A: Array | None, biased: bool) -> None:
    spacecraft, model, x0, plan, omega0, speed0, before = case(A, biased)
    torque = ramped(plan, before, 0.4, PERIOD)
    t = times(len(plan) + 1, PERIOD)
    f = flown(spacecraft, torque, t, Q, omega0, speed0)
    end, _, x = propagate(build_propagators(spacecraft), model, x0, plan, PERIOD, GOAL)
    assert np.max(np.abs(x[:, :4] - f.q)) < (1.5e-4 if biased else 1e-6)
    p = spin_momentum(spacecraft, f.omega, f.speed)
    assert np.max(np.abs(x[:, 4:6] - p)) < 1e-7  # Nms
    apart = matrix(GOAL).T @ matrix(f.q[-1])
    vector = 0.5 * np.array(
        [apart[2, 1] - apart[1, 2], apart[0, 2] - apart[2, 0], apart[1, 0] - apart[0, 1]]
    )
    sine = vector / np.sqrt(1.0 + np.trace(apart))  # q_v of a rotation matrix, q_0 > 0
    assert np.max(np.abs(end[:3] - 2.0 * sine)) < 3e-4


def test_the_slope_is_the_derivative() -> None:
    spacecraft, model, x0, plan, *_ = case(biased=True)
    propagators = build_propagators(spacecraft)
    _, slope, _ = propagate(propagators, model, x0, plan, PERIOD, GOAL)
    for k in (0, 7, 13, 19):
        step = np.zeros(plan.size)
        step[k] = 1e-6
        more, _, _ = propagate(
            propagators, model, x0, plan + step.reshape(plan.shape), PERIOD, GOAL
        )
        less, _, _ = propagate(
            propagators, model, x0, plan - step.reshape(plan.shape), PERIOD, GOAL
        )
        assert np.max(np.abs((more - less) / 2e-6 - slope[:, k])) < 1e-5


def test_the_length_of_the_function_does_not_matter() -> None:
    spacecraft, model, x0, plan, *_ = case(K=8)
    propagators = build_propagators(spacecraft)
    ends = [propagate({N: propagators[N]}, model, x0, plan, PERIOD, GOAL)[0] for N in LENGTHS]
    assert np.ptp(np.array(ends), axis=0).max() < 1e-14


def test_at_rest_in_the_goal_nothing_is_left_over() -> None:
    spacecraft = craft()
    x0 = np.concatenate([TARGET, np.zeros(4)])
    model = MomentumModel(spacecraft, TRUE_J, np.array([0.0, 0.0, 0.0]))
    for sign in (1.0, -1.0):
        end, _, _ = propagate(
            build_propagators(spacecraft), model, x0, np.zeros((5, 2)), PERIOD, sign * TARGET
        )
        assert np.all(end == 0.0)
