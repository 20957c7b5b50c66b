import numpy as np

from simsat.control.model.rates import build_rate_model, predict_rate
from simsat.learning.correction.linear import fit_linear
from simsat.learning.correction.rollout import (
    build_problem,
    rate_error,
    residual_scale,
    rollout_loss,
)
from simsat.learning.correction.windows import cut, joined, shifted
from simsat.learning.sequence import self_fed
from simsat.mjcf import Model
from tests.learning_cases import PERIOD, TICKS, believed_of, made_up_flights, made_up_windows

import torch  # isort: skip


def test_windows_start_at_control_instants(two_wheel: Model) -> None:
    flights = made_up_flights(two_wheel, 2, 6)
    rate_max = two_wheel.spacecraft.torque_rate_max
    windows = cut(flights, PERIOD, believed_of(two_wheel), rate_max)
    for k in range(6):
        row = k * TICKS
        assert np.array_equal(windows.omega[1, k], flights[1].omega[row])
        assert np.array_equal(windows.omega_before[1, k], flights[1].omega[max(row - TICKS, 0)])
        assert np.array_equal(windows.omega_after[1, k], flights[1].omega[row + TICKS])
        assert np.array_equal(windows.torque[1, k], flights[1].torque[k])
    assert np.array_equal(joined(windows, windows).pick([3]).omega, windows.pick([1]).omega)


def test_a_right_model_misses_nothing(two_wheel: Model) -> None:
    flights = made_up_flights(two_wheel, 2, 6)
    truth = build_rate_model(two_wheel.spacecraft, friction=False)
    windows = cut(flights, PERIOD, truth, two_wheel.spacecraft.torque_rate_max)
    assert np.abs(windows.residual).max() < 1e-6  # Nm


def test_the_residual_follows_from_the_two_inertias(two_wheel: Model) -> None:
    """At zero momentum nothing but -A u turns the craft: the nominal model misses
    (J_nominal J_true^-1 - 1)(-A u), seen from the wheels through the rate error."""
    windows = made_up_windows(two_wheel, 4, 10)
    craft, believed = two_wheel.spacecraft, believed_of(two_wheel)
    mean_torque = windows.torques.mean(axis=2)
    push = np.linalg.inv(craft.J_hub) - believed.J_hub_inverse
    missed_rate = -PERIOD * mean_torque @ (push @ craft.A).T
    effect = PERIOD * believed.J_hub_inverse @ craft.A
    expected = missed_rate @ np.linalg.pinv(effect).T
    error = np.sqrt(np.mean((windows.residual - expected) ** 2))
    assert error < 0.03 * np.sqrt(np.mean(expected**2))  # the rest is gyroscopic


def test_the_oracle_leaves_next_to_no_loss_and_the_nominal_model_has_one(two_wheel: Model) -> None:
    windows, believed = made_up_windows(two_wheel, 4, 10), believed_of(two_wheel)
    problem = build_problem(windows, believed, residual_scale(windows))
    rows = torch.arange(40)
    residual = torch.as_tensor(windows.residual.reshape(40, 2))
    assert float(rollout_loss(problem, residual, rows)) < 1e-4
    nothing = torch.zeros_like(residual)
    assert abs(float(rollout_loss(problem, nothing, rows)) - 1.0) < 1e-12
    expected = predict_rate(
        believed, windows.omega, windows.wheel_speed, windows.torques, np.zeros(3), PERIOD
    )
    error = rate_error(problem, nothing, rows).numpy()
    assert np.allclose(error, (expected - windows.omega_after).reshape(40, 3), atol=1e-15)


def test_the_loss_sees_the_estimate_through_the_dynamics_alone(two_wheel: Model) -> None:
    """Its gradient by autograd agrees with central differences."""
    windows, believed = made_up_windows(two_wheel, 1, 8), believed_of(two_wheel)
    problem = build_problem(windows, believed, residual_scale(windows))
    rows = torch.arange(8)
    tau = torch.full((8, 2), 1e-3, dtype=torch.float64, requires_grad=True)
    rollout_loss(problem, tau, rows).backward()
    step = 1e-5
    for place in ((0, 0), (5, 1)):
        shift = torch.zeros(8, 2, dtype=torch.float64)
        shift[place] = step
        with torch.no_grad():
            up = float(rollout_loss(problem, tau + shift, rows))
            down = float(rollout_loss(problem, tau - shift, rows))
        assert tau.grad is not None
        assert abs((up - down) / (2 * step) / float(tau.grad[place]) - 1.0) < 1e-6


def test_least_squares_finds_a_linear_residual(two_wheel: Model) -> None:
    """Without ramps and turning the residual is linear in the torque, and least squares exact."""
    windows, believed = made_up_windows(two_wheel, 12, 30), believed_of(two_wheel)
    network = fit_linear(windows, believed)
    unseen = made_up_windows(two_wheel, 4, 30, seed=1)
    left = self_fed(network, unseen, believed) - unseen.residual
    assert np.sqrt(np.mean(left**2)) < 0.1 * np.sqrt(np.mean(unseen.residual**2))


def test_each_estimate_is_fed_into_the_next(two_wheel: Model) -> None:
    windows, believed = made_up_windows(two_wheel, 3, 5), believed_of(two_wheel)
    network = fit_linear(windows, believed)
    network.weights[0][:, 0] = 0.3  # the previous estimate now counts
    estimates = self_fed(network, windows, believed)
    x = windows.features(shifted(estimates), believed)
    assert np.allclose(network.estimate(x), estimates, rtol=1e-12, atol=1e-18)
    assert not np.any(shifted(estimates)[:, 0])
