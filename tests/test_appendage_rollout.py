"""The roll-out loss and its training, on craft with exact oscillators."""

import io
from dataclasses import replace

import numpy as np
import pytest
import torch

from control.learned.appendage import advance, growth
from learning.appendage_fit import (
    AppendageFitSettings,
    AppendageState,
    Course,
    Fleet,
    blank,
    build_course,
    next_round,
    run_epoch,
)
from learning.appendage_linear import build_appendage
from learning.appendage_rollout import (
    Appendage,
    Loss,
    as_module,
    as_network,
    build_rollouts,
    loss_scale,
    rate_errors,
    without_network,
)
from learning.appendage_series import Series, build_series
from learning.progress import best_module, pack, unpack
from simsat.errors import SettingsError
from simsat.mjcf import Model
from simsat.spacecraft import Spacecraft, nominal
from tests.appendage_cases import DAMPING, PERIOD, TICKS, made_up_flights

torch.set_num_threads(1)

SETTINGS = AppendageFitSettings(width=4, horizon=6, epochs=4, iterations=10, rate_noise=0.0)


@pytest.fixture(scope="module")
def craft(two_wheel: Model) -> Spacecraft:
    return two_wheel.spacecraft


def exact(craft: Spacecraft, count: int, seed: int = 0) -> Series:
    """The series at the true inertia, with the true c: no drift was fitted."""
    flights, truth = made_up_flights(craft, count, 24, seed)
    series = build_series(flights, craft, craft.J, PERIOD)
    means = build_series(flights, craft, craft.J, PERIOD).mean
    weights = np.array([1, 4, 2, 4, 2, 4, 2, 4, 2, 4, 1]) / 30.0
    for k in range(means.shape[1]):
        means[:, k] = np.einsum("fti,t->fi", truth[:, k * TICKS : (k + 1) * TICKS + 1], weights)
    return replace(
        series,
        c=truth[:, ::TICKS],
        c_slope=0.0 * series.c_slope,
        mean=means,
        mean_slope=0.0 * series.mean_slope,
        product=0.0 * series.product,
    )


@pytest.fixture(scope="module")
def fleet(craft: Spacecraft) -> Fleet:
    J_0 = nominal(craft).J
    parts = []
    for seed, count in ((0, 8), (1, 2), (2, 2)):
        flights, _ = made_up_flights(craft, count, 40, seed)
        parts.append(build_series(flights, craft, J_0, PERIOD))
    return Fleet(*parts)


@pytest.fixture(scope="module")
def course(fleet: Fleet, craft: Spacecraft) -> Course:
    return build_course(fleet, craft, nominal(craft).J, SETTINGS, seed=0)


def trained(course: Course, craft: Spacecraft, epochs: int) -> AppendageState:
    """Half of the epochs linear, half with the tanh layer."""
    state = blank(1, course, craft, SETTINGS)
    go_on(state, course, craft, epochs)
    return state


def go_on(state: AppendageState, course: Course, craft: Spacecraft, epochs: int) -> None:
    for _ in range(epochs):
        if state.finished and state.round == 1:
            next_round(state, craft, SETTINGS, seed=0)
        run_epoch(state, course, SETTINGS)


def weights(module: Appendage) -> list[np.ndarray]:
    return [value.detach().numpy().copy() for value in module.parameters()]


def same(a: Appendage, b: Appendage) -> bool:
    return all(np.array_equal(p, q) for p, q in zip(weights(a), weights(b), strict=True))


def test_two_exact_oscillators_obey_the_recursion(craft: Spacecraft) -> None:
    """c of two modes needs no more than two instants of it: least squares predicts 16 periods."""
    module = build_appendage(exact(craft, 6), craft, craft.J, noise=0.0)
    unseen = build_rollouts(exact(craft, 2, seed=5), 16, 0.0, 0)
    with torch.no_grad():
        wrong, nothing = (rate_errors(module, unseen, step) for step in (None, without_network))
    for error, size in zip(wrong, nothing, strict=True):
        assert error.abs().max() < 1e-7 * size.abs().max()
    slowest = 2.0 * np.pi * 0.27 * DAMPING[1]  # 1/s, hub held; a free hub raises it
    assert np.exp(-2.0 * slowest * PERIOD) < growth(as_network(module, PERIOD)) < 1.0


def test_training_learns_inertia_and_oscillators_together(
    course: Course, craft: Spacecraft
) -> None:
    before = float(course.held_out(course.first).detach())
    state = trained(course, craft, 4)
    learned = best_module(state)
    assert state.best_loss < 0.5 * before
    assert state.best_loss < 1e-3  # 3 % of the rate error without a network
    wrong = (learned.J.detach().numpy() - craft.J)[:2, :2]
    assert np.abs(wrong).max() < 0.02 * craft.J[0, 0]  # kg m^2; the belief is 7 % off


def test_without_a_network_the_loss_is_one(course: Course, craft: Spacecraft) -> None:
    empty = as_module(as_network(course.first, PERIOD), craft, nominal(craft).J)
    with torch.no_grad():
        empty.W.zero_()
    assert float(course.training(empty).detach()) == pytest.approx(1.0, rel=1e-12)


def test_the_roll_out_is_the_networks_own_recursion(course: Course, craft: Spacecraft) -> None:
    """Roll-outs by hand with what flies, from zeros before the flight, give torch's errors."""
    state = trained(course, craft, 5)
    module, network = state.module, as_network(state.module, PERIOD)
    rollouts = course.held_out.rollouts
    ends, means = rate_errors(module, rollouts)
    c = (rollouts.c + rollouts.c_slope @ module.inertia).detach().numpy()
    average = (rollouts.mean + rollouts.mean_slope @ module.inertia).detach().numpy()
    u = rollouts.torque.numpy()
    assert not c[0, 0].any()  # before the flight
    assert not u[0, :2].any()
    back = np.linalg.inv(network.J - (craft.A * craft.Js) @ craft.A.T)
    before, now = c[:, 0], c[:, 1]
    for j in range(rollouts.horizon):
        after, mean = advance(network, now, before, u[:, j + 2], u[:, j + 1], u[:, j])
        before, now = now, after
        assert np.abs((now - c[:, j + 2]) @ back.T - ends[:, j].detach().numpy()).max() < 1e-12
        assert np.abs((mean - average[:, j]) @ back.T - means[:, j].detach().numpy()).max() < 1e-12


def test_noise_enters_at_the_start_alone(fleet: Fleet, course: Course) -> None:
    clean = build_rollouts(fleet.held_out, 6, 0.0, 0)
    noisy, again = (build_rollouts(fleet.held_out, 6, 1e-4, 7) for _ in range(2))
    assert torch.equal(noisy.noise, again.noise)
    assert float(noisy.noise.std()) == pytest.approx(1e-4, rel=0.1)
    assert torch.equal(noisy.c, clean.c)
    scale = loss_scale(course.first, clean)
    losses = [float(Loss(r, scale)(course.first).detach()) for r in (clean, noisy)]
    assert losses[1] > losses[0]


def test_gradients_are_those_of_finite_differences(course: Course, craft: Spacecraft) -> None:
    module = trained(course, craft, 5).module
    module.zero_grad()
    course.held_out(module).backward()
    for parameter in module.parameters():
        step = 1e-6
        with torch.no_grad():
            at = parameter.view(-1)[0].item()
            values = []
            for sign in (1.0, -1.0):
                parameter.view(-1)[0] = at + sign * step
                values.append(float(course.held_out(module)))
            parameter.view(-1)[0] = at
        slope = (values[0] - values[1]) / (2.0 * step)
        assert float(parameter.grad.view(-1)[0]) == pytest.approx(slope, rel=1e-4, abs=1e-9)


def test_a_restart_from_a_checkpoint_changes_nothing(course: Course, craft: Spacecraft) -> None:
    """Broken off in the first round and in the second."""
    whole = trained(course, craft, 6)
    for done in (2, 5):
        buffer = io.BytesIO()
        torch.save(pack(trained(course, craft, done)), buffer)
        buffer.seek(0)
        checkpoint = torch.load(buffer, weights_only=True)
        state = unpack(checkpoint, blank(checkpoint["round"], course, craft, SETTINGS))
        go_on(state, course, craft, 6 - done)
        assert state.round == 2
        assert same(state.module, whole.module)
        assert state.curves == whole.curves


def test_a_module_comes_back_from_its_network(course: Course, craft: Spacecraft) -> None:
    module = trained(course, craft, 5).module
    back = as_module(as_network(module, PERIOD), craft, nominal(craft).J)
    for a, b in zip(weights(module), weights(back), strict=True):
        assert np.abs(a - b).max() < 1e-14


def test_a_horizon_longer_than_the_flights_is_refused(fleet: Fleet, craft: Spacecraft) -> None:
    with pytest.raises(
        SettingsError, match=r"--fit.horizon is 60 periods, but the flights have 40"
    ):
        build_course(fleet, craft, craft.J, replace(SETTINGS, horizon=60), seed=0)
    with pytest.raises(SettingsError, match=r"--fit.horizon is 0: give a finite number from 1 up"):
        AppendageFitSettings(horizon=0)
