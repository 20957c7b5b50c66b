import casadi as ca
import numpy as np
import pytest
import torch

from simsat.control.ground.arrays import Array
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.dynamics import build_dynamics, rk4_step
from simsat.control.model.ramp import ramped_torques
from simsat.control.model.rates import (
    build_rate_model,
    missed_torque,
    predict_rate,
    rate_effect,
)
from simsat.learning.correction.rollout import as_tensors
from simsat.mjcf import Model, read_model
from simsat.mjcf.shipped import MODELS
from simsat.plant.plant import Plant

PERIOD = 0.5
RANDOM = np.random.default_rng(7)
OMEGA = 0.1 * RANDOM.standard_normal((20, 3))
SPEED = 300.0 * RANDOM.standard_normal((20, 2))  # a large bias: every gyroscopic term counts
TORQUE = 0.05 * RANDOM.uniform(-1.0, 1.0, (20, 2))
TAU = 0.01 * RANDOM.standard_normal((20, 3))


def held(torque: Array, steps: int = 10) -> Array:
    return np.repeat(torque[..., None, :], steps, axis=-2)


def casadi_rates(craft: Spacecraft, k: int, friction: bool, steps: int) -> Array:
    derivative = build_dynamics(craft, friction)
    state = ca.vertcat(1.0, 0.0, 0.0, 0.0, OMEGA[k], SPEED[k])
    for _ in range(steps):
        state = rk4_step(lambda s: derivative(s, TORQUE[k], TAU[k]), state, PERIOD / steps)
    return np.asarray(state)[4:7, 0]


def test_it_agrees_with_the_planners_model(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    ours = predict_rate(build_rate_model(craft, False), OMEGA, SPEED, held(TORQUE), TAU, PERIOD)
    for k in range(len(OMEGA)):
        assert np.abs(ours[k] - casadi_rates(craft, k, False, 10)).max() < 1e-9  # rad/s


def test_friction_agrees_with_the_planners_model() -> None:
    craft = read_model(MODELS / "two_wheel_friction" / "two_wheel_friction.xml").spacecraft
    model = build_rate_model(craft, True)
    fast = np.abs(SPEED).min(axis=1) > 40.0  # rad/s; nearer to rest the two smooth differently
    ours = predict_rate(model, OMEGA, SPEED, held(TORQUE), TAU, PERIOD)
    free = predict_rate(build_rate_model(craft, False), OMEGA, SPEED, held(TORQUE), TAU, PERIOD)
    for k in np.flatnonzero(fast).tolist():
        error = np.abs(ours[k] - casadi_rates(craft, k, True, 10)).max()
        assert error < 0.01 * np.abs(ours[k] - free[k]).max()


def test_it_agrees_with_mujoco(two_wheel: Model) -> None:
    model = build_rate_model(two_wheel.spacecraft, False)
    for k in range(5):
        plant = Plant(two_wheel, 0.05, 20)
        plant.reset(np.array([1.0, 0.0, 0.0, 0.0]), OMEGA[k], SPEED[k])
        plant.advance(TORQUE[k], 10)  # the ramp
        state = plant.state()
        plant.advance(TORQUE[k], 10)
        rate = predict_rate(
            model, state.omega, state.wheel_speed, held(TORQUE[k]), np.zeros(3), PERIOD
        )
        assert np.abs(rate - plant.state().omega).max() < 1e-9  # rad/s


def test_the_ramp_agrees_with_mujoco(two_wheel: Model) -> None:
    craft = two_wheel.spacecraft
    before, after = np.array([0.04, -0.02]), np.array([-0.04, 0.048])  # whole steps of the drive
    plant = Plant(two_wheel, 0.05, 20)
    plant.reset(np.array([1.0, 0.0, 0.0, 0.0]), OMEGA[0], np.array([100.0, -100.0]))
    plant.advance(before, 10)
    state = plant.state()
    plant.advance(after, 10)
    torques = ramped_torques(after, before, craft.torque_rate_max, PERIOD)
    rate = predict_rate(
        build_rate_model(craft, False), state.omega, state.wheel_speed, torques, np.zeros(3), PERIOD
    )
    assert np.abs(rate - plant.state().omega).max() < 1e-6  # rad/s; the ramp itself moves 0.01


def test_torch_and_numpy_are_one_piece_of_code(two_wheel: Model) -> None:
    model = build_rate_model(two_wheel.spacecraft, True)
    numbers = predict_rate(model, OMEGA, SPEED, held(TORQUE), TAU, PERIOD)
    omega, speed, torques, tau = map(torch.as_tensor, (OMEGA, SPEED, held(TORQUE), TAU))
    tensors = predict_rate(as_tensors(model), omega, speed, torques, tau, PERIOD)
    assert np.abs(numbers - tensors.numpy()).max() < 1e-15


def test_the_order_is_four(two_wheel: Model) -> None:
    model = build_rate_model(two_wheel.spacecraft, False)

    def rates(steps: int) -> Array:
        return predict_rate(model, 5 * OMEGA, 2 * SPEED, held(TORQUE, steps), TAU, PERIOD)

    exact = rates(256)
    coarse, fine = (np.abs(rates(steps) - exact).max() for steps in (2, 4))
    assert 3.7 < np.log2(coarse / fine) < 4.5


@pytest.mark.parametrize("change", [0.0, 0.013, -0.08])
def test_a_ramp_withholds_its_closed_form_impulse(change: float) -> None:
    rate = 0.4
    before = np.array([0.01, 0.02])
    torques = ramped_torques(before + change, before, np.array([rate, np.inf]), PERIOD)
    mean = torques.mean(axis=0) - before
    assert abs(mean[0] - (change - abs(change) * change / (2 * rate * PERIOD))) < 1e-15
    assert abs(mean[1] - change) < 1e-15  # no rate limit, no ramp
    assert np.allclose(torques[-1], before + change, atol=1e-15)  # it ends inside the period


def test_a_ramp_that_cannot_end_uses_the_whole_period() -> None:
    rate = 0.1
    before, after = np.array([0.0]), np.array([0.2])
    torques = ramped_torques(after, before, np.array([rate]), PERIOD)[:, 0]
    t = (np.arange(10) + 0.5) * PERIOD / 10
    assert np.allclose(torques, rate * t, atol=1e-15)


def test_a_planted_torque_is_found_again(two_wheel: Model) -> None:
    model = build_rate_model(two_wheel.spacecraft, False)
    at_rest = np.zeros((20, 3)), np.zeros((20, 2))
    planted = 0.01 * RANDOM.standard_normal((20, 2))
    torques = np.zeros((20, 10, 2))
    rate = predict_rate(model, *at_rest, torques, planted @ model.A.T, PERIOD)
    assert np.abs(missed_torque(model, rate, PERIOD) - planted).max() < 1e-5  # Nm: to first order
    assert np.allclose(rate, planted @ rate_effect(model, PERIOD).T, atol=1e-5)
