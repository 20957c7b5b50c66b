"""The roll-out loss and its training, on craft with exact oscillators."""

import io
from dataclasses import replace

import numpy as np
import pytest
import torch

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.spacecraft import Spacecraft, nominal
from simsat.control.model.appendage import next_momentum, spectral_radius
from simsat.learning.appendage.fit import (
    GATE,
    TANH,
    AppendageFitSettings,
    AppendageState,
    Fleet,
    TrainingProblem,
    begin,
    build_training_problem,
    layers_to_train,
    run_epoch,
)
from simsat.learning.appendage.linear import build_appendage
from simsat.learning.appendage.rollout import (
    ALONG,
    Appendage,
    Loss,
    Recursion,
    Rollouts,
    as_module,
    as_network,
    build_rollouts,
    loss_scale,
    mean_squares,
    rate_errors,
    without_network,
)
from simsat.learning.appendage.series import Series, build_series
from simsat.learning.progress import best_module, pack, unpack
from simsat.mjcf import Model
from tests.appendage_cases import DAMPING, PERIOD, TICKS, made_up_flights

torch.set_num_threads(1)

SETTINGS = AppendageFitSettings(
    width=4, gates=2, horizon=6, epochs=4, iterations=10, rate_noise=0.0
)


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


def turning(series: Series) -> Series:
    """c along z is c along x a period ago times the second rotor's spin momentum."""
    c, mean = series.c.copy(), series.mean.copy()
    product = 10.0 * c[:, :-1, 0] * series.spin[..., 1]  # 10 per Nms
    c[:, 0, 2], c[:, 1:, 2], mean[..., 2] = 0.0, product, 0.5 * product
    return replace(series, c=c, mean=mean)


@pytest.fixture(scope="module")
def fleet(craft: Spacecraft) -> Fleet:
    J_0 = nominal(craft).J
    parts = []
    for seed, count in ((0, 8), (1, 2), (2, 2)):
        flights, _ = made_up_flights(craft, count, 40, seed)
        parts.append(build_series(flights, craft, J_0, PERIOD))
    return Fleet(*parts)


@pytest.fixture(scope="module")
def problem(fleet: Fleet, craft: Spacecraft) -> TrainingProblem:
    return build_training_problem(fleet, craft, nominal(craft).J, SETTINGS, seed=0)


def trained(problem: TrainingProblem, epochs: int) -> AppendageState:
    """Four epochs linear, four with the gate, the rest with the tanh layer too."""
    number = (epochs - 1) // SETTINGS.epochs + 1
    return go_on(opened(problem, number), problem, epochs - SETTINGS.epochs * (number - 1))


def opened(problem: TrainingProblem, number: int) -> AppendageState:
    """A round that has only begun."""
    done = SETTINGS.epochs * (number - 1)
    before = best_module(trained(problem, done)) if done else problem.first
    return begin(number, layers_to_train(SETTINGS)[number - 1], before, SETTINGS, seed=0)


def go_on(state: AppendageState, problem: TrainingProblem, epochs: int) -> AppendageState:
    for _ in range(epochs):
        run_epoch(state, problem, SETTINGS)
    return state


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
    assert (
        np.exp(-2.0 * slowest * PERIOD)
        < spectral_radius(as_network(module, PERIOD), np.zeros(2))
        < 1.0
    )


def test_training_learns_inertia_and_oscillators_together(
    problem: TrainingProblem, craft: Spacecraft
) -> None:
    before = float(problem.held_out(problem.first).detach())
    state = trained(problem, 4)
    learned = best_module(state)
    assert state.best_loss < 0.5 * before
    assert state.best_loss < 1e-3  # 3 % of the rate error without a network
    wrong = (learned.J.detach().numpy() - craft.J)[:2, :2]
    assert np.abs(wrong).max() < 0.02 * craft.J[0, 0]  # kg m^2; the belief is 7 % off


def test_the_gate_learns_what_turns_with_the_body(craft: Spacecraft) -> None:
    """It is a product: least squares and the tanh layer miss it."""
    fleet = Fleet(*(turning(exact(craft, count, seed)) for seed, count in enumerate((6, 2, 2))))
    problem = build_training_problem(fleet, craft, craft.J, SETTINGS, seed=0)
    left = {}
    for layer in (GATE, TANH):
        state = go_on(begin(1, layer, problem.first, SETTINGS, seed=0), problem, 8)
        with torch.no_grad():
            left[layer] = mean_squares(state.module, problem.held_out.rollouts)[2:]
            nothing = mean_squares(state.module, problem.held_out.rollouts, without_network)[2:]
    assert (left[GATE] < 0.01 * nothing).all()
    assert (left[TANH] > 0.1 * nothing).all()


def test_the_loss_is_the_formula(problem: TrainingProblem, craft: Spacecraft) -> None:
    """Rates on all axes, and momentum along n: by hand, from J_hub times the rate errors."""
    module, rollouts = problem.first, problem.held_out.rollouts
    J_hub = module.J.detach().numpy() - (craft.A * craft.Js) @ craft.A.T

    def squares(step: Recursion | None, over: Rollouts) -> Array:
        errors = [error.detach().numpy() for error in rate_errors(module, over, step)]
        rates = [np.mean(np.sum(error**2, axis=-1)) for error in errors]
        return np.array(
            rates + [np.mean((error @ J_hub @ craft.unactuated) ** 2) for error in errors]
        )

    left = squares(None, rollouts) / squares(without_network, problem.training.rollouts)
    by_hand = left @ [1.0, 1.0, ALONG, ALONG] / (2.0 + 2.0 * ALONG)
    assert problem.held_out_loss(module) == pytest.approx(by_hand, rel=1e-10)


def test_without_a_network_the_loss_is_one(problem: TrainingProblem, craft: Spacecraft) -> None:
    empty = as_module(as_network(problem.first, PERIOD), craft, nominal(craft).J)
    with torch.no_grad():
        empty.W.zero_()
    assert float(problem.training(empty).detach()) == pytest.approx(1.0, rel=1e-12)


def test_the_roll_out_is_the_networks_own_recursion(
    problem: TrainingProblem, craft: Spacecraft
) -> None:
    """Roll-outs by hand with what flies, from zeros before the flight, give torch's errors."""
    state = trained(problem, 9)
    module, network = state.module, as_network(state.module, PERIOD)
    rollouts = problem.held_out.rollouts
    ends, means = rate_errors(module, rollouts)
    c = (rollouts.c + rollouts.c_slope @ module.inertia).detach().numpy()
    average = (rollouts.mean + rollouts.mean_slope @ module.inertia).detach().numpy()
    u, p = rollouts.torque.numpy(), rollouts.spin.numpy()
    assert not c[0, 0].any()  # before the flight
    assert not u[0, :2].any()
    back = np.linalg.inv(network.J - (craft.A * craft.Js) @ craft.A.T)
    before, now = c[:, 0], c[:, 1]
    for j in range(rollouts.horizon):
        after, mean = next_momentum(
            network, now, before, u[:, j + 2], u[:, j + 1], u[:, j], p[:, j]
        )
        before, now = now, after
        assert np.abs((now - c[:, j + 2]) @ back.T - ends[:, j].detach().numpy()).max() < 1e-12
        assert np.abs((mean - average[:, j]) @ back.T - means[:, j].detach().numpy()).max() < 1e-12


def test_noise_enters_at_the_start_alone(fleet: Fleet, problem: TrainingProblem) -> None:
    clean = build_rollouts(fleet.held_out, 6, 0.0, 0)
    noisy, again = (build_rollouts(fleet.held_out, 6, 1e-4, 7) for _ in range(2))
    assert torch.equal(noisy.noise, again.noise)
    assert float(noisy.noise.std()) == pytest.approx(1e-4, rel=0.1)
    assert torch.equal(noisy.c, clean.c)
    scale = loss_scale(problem.first, clean)
    losses = [float(Loss(r, scale)(problem.first).detach()) for r in (clean, noisy)]
    assert losses[1] > losses[0]


def test_gradients_are_those_of_finite_differences(
    problem: TrainingProblem, craft: Spacecraft
) -> None:
    module = trained(problem, 9).module
    module.zero_grad()
    problem.held_out(module).backward()
    for parameter in module.parameters():
        step = 1e-6
        with torch.no_grad():
            at = parameter.view(-1)[0].item()
            values = []
            for sign in (1.0, -1.0):
                parameter.view(-1)[0] = at + sign * step
                values.append(float(problem.held_out(module)))
            parameter.view(-1)[0] = at
        slope = (values[0] - values[1]) / (2.0 * step)
        assert float(parameter.grad.view(-1)[0]) == pytest.approx(slope, rel=1e-4, abs=1e-9)


@pytest.mark.parametrize("done", [2, 5, 9])
def test_a_restart_from_a_checkpoint_changes_nothing(problem: TrainingProblem, done: int) -> None:
    """Broken off in any round."""
    buffer = io.BytesIO()
    torch.save(pack(trained(problem, done)), buffer)
    buffer.seek(0)
    checkpoint = torch.load(buffer, weights_only=True)
    state = unpack(checkpoint, opened(problem, checkpoint["round"]))
    whole = trained(problem, done + 2)
    go_on(state, problem, 2)
    assert state.round == whole.round
    assert same(state.module, whole.module)
    assert state.curves == whole.curves


def test_a_module_comes_back_from_its_network(problem: TrainingProblem, craft: Spacecraft) -> None:
    module = trained(problem, 9).module
    back = as_module(as_network(module, PERIOD), craft, nominal(craft).J)
    for a, b in zip(weights(module), weights(back), strict=True):
        assert np.abs(a - b).max() < 1e-14


def test_a_horizon_longer_than_the_flights_is_refused(fleet: Fleet, craft: Spacecraft) -> None:
    with pytest.raises(
        SettingsError, match=r"--fit.horizon is 60 periods, but the flights have 40"
    ):
        build_training_problem(fleet, craft, craft.J, replace(SETTINGS, horizon=60), seed=0)
    with pytest.raises(SettingsError, match=r"--fit.horizon is 0: give a whole number from 1 up"):
        AppendageFitSettings(horizon=0)
