"""The appendage network as it flies: one function in NumPy, CasADi and torch, odd, decaying."""

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import torch
from scipy.integrate import cumulative_trapezoid, trapezoid

from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import IDENTITY
from simsat.control.learned.prediction.propagation import build_propagator
from simsat.control.model.appendage import (
    AppendageNetwork,
    next_momentum,
    spectral_radius,
    symbolic_momentum,
)
from simsat.control.model.momentum import MomentumModel
from simsat.learning.appendage.rollout import WEIGHTS, Appendage, Scales
from simsat.mjcf import Model, read_model
from simsat.mjcf.shipped import find_model
from simsat.networks.appendage import read_appendage, shipped_appendage
from tests.appendage_cases import PERIOD, random_network

SHIPPED = ("flexible_panels",)


def networks() -> list[AppendageNetwork]:
    shipped = []
    for name in SHIPPED:
        path = shipped_appendage(Path(name))
        assert path is not None
        craft = read_model(find_model(Path(name))).spacecraft
        shipped.append(read_appendage(path, craft, PERIOD))
    made_up = [
        random_network(),
        random_network(width=0),
        random_network(gates=0),
        random_network(width=0, gates=0),
        random_network(wheels=3),
    ]
    return made_up + shipped


def parts_of(x: Array, wheels: int) -> list[Array]:
    """(c, c_before, u, u_before, u_before2, p) of x (..., 6 + 4 m)."""
    ends = np.cumsum([3, 3, wheels, wheels, wheels])
    return np.split(x, ends, axis=-1)


def scale_of(network: AppendageNetwork) -> Array:
    """Of all inputs, p included."""
    return np.concatenate([network.input_scale, network.spin_scale])


def torch_twin(network: AppendageNetwork, model: Model) -> Appendage:
    scales = Scales(network.input_scale, network.spin_scale, network.output_scale)
    module = Appendage(model.spacecraft, network.J, scales, network.width, network.gates)
    for name in WEIGHTS:
        getattr(module, name).data = torch.as_tensor(getattr(network, name))
    return module


@pytest.mark.parametrize("network", networks())
def test_numpy_casadi_and_torch_agree_in_value_and_slope(
    network: AppendageNetwork, two_wheel: Model
) -> None:
    module = torch_twin(network, two_wheel)
    scale = network.output_scale.max()
    ends = len(network.input_scale)
    slopes = {kind: _casadi_slope(network, kind) for kind in (ca.SX, ca.MX)}
    scales = scale_of(network)
    for x in np.random.default_rng(0).standard_normal((5, len(scales))) * scales:
        tensors = (torch.as_tensor(x[:ends]), torch.as_tensor(x[ends:]))
        answer = module(*tensors).detach().numpy()
        slope = torch.cat(torch.autograd.functional.jacobian(module, tensors), dim=-1).numpy()
        numbers = np.concatenate(next_momentum(network, *parts_of(x, network.wheels)))
        assert np.abs(numbers - answer).max() < 1e-9 * scale
        for function in slopes.values():
            value, jacobian = (np.array(out) for out in function(x))
            assert np.abs(value.ravel() - answer).max() < 1e-9 * scale
            in_scales = (jacobian - slope) * scales
            assert np.abs(in_scales).max() < 1e-9 * scale


def _casadi_slope(network: AppendageNetwork, kind: type) -> ca.Function:
    """(x, p) -> (output, its slope by both)."""
    x = kind.sym("x", len(scale_of(network)))  # type: ignore[attr-defined]
    ends = [0, *np.cumsum([3, 3, *[network.wheels] * 4]).tolist()]
    y = ca.vertcat(*symbolic_momentum(network.size, ca.DM(network.numbers), *ca.vertsplit(x, ends)))
    return ca.Function("slope", [x], [y, ca.jacobian(y, x)])


def test_a_plan_asks_it_with_the_mean_spin(two_wheel: Model) -> None:
    """The momenta that an arc predicts are its recursion, p' = u with the motors' ramps."""
    craft = two_wheel.spacecraft
    network = random_network()
    network = replace(network, output_scale=0.01 * network.output_scale)
    torque = np.random.default_rng(6).uniform(-0.05, 0.05, (5, 2))
    c, before, p = np.array([1e-3, -2e-3, 5e-4]), np.array([0.0, 0.0, 0.0]), np.array([0.1, -0.2])
    u1, u2 = np.zeros((2, 2))
    x0 = np.concatenate([IDENTITY, p, u1, c, before, u2])
    model = MomentumModel(craft, craft.J, np.array([0.0, 0.0, 0.0]))
    propagator, lengths = build_propagator(craft, network), np.full(len(torque), PERIOD)
    _, _, x = propagator.linearize(model, x0, torque, lengths, IDENTITY)
    t = np.linspace(0.0, PERIOD, 100_001)
    for k, u in enumerate(torque):
        ramp = u1 + np.sign(u - u1) * craft.torque_rate_max * t[:, None]
        given = np.where(np.abs(ramp - u1) < np.abs(u - u1), ramp, u)
        path = p + cumulative_trapezoid(given, t, axis=0, initial=0.0)
        c, before = (
            next_momentum(network, c, before, u, u1, u2, trapezoid(path, t, axis=0) / PERIOD)[0],
            c,
        )
        p, u1, u2 = path[-1], u, u1
        assert np.abs(x[k + 1, 4:6] - p).max() < 1e-7  # Nms
        assert np.abs(x[k + 1, 8:11] - c).max() < 1e-8  # Nms


def test_batches_are_rows() -> None:
    network = random_network()
    x = 0.05 * np.random.default_rng(1).standard_normal((4, 3, 14))
    c, mean = next_momentum(network, *parts_of(x, 2))
    assert c.shape == mean.shape == (4, 3, 3)
    one = next_momentum(network, *parts_of(x[2, 1], 2))
    assert np.allclose(c[2, 1], one[0], rtol=1e-12)
    assert np.allclose(mean[2, 1], one[1], rtol=1e-12)


@pytest.mark.parametrize("network", networks())
def test_it_is_odd_in_x_and_nothing_moves_without_a_cause(network: AppendageNetwork) -> None:
    """However fast the rotors turn: deflection is turned about, not made."""
    scales = scale_of(network)
    x = np.random.default_rng(2).standard_normal(len(scales)) * scales
    causes = np.repeat([1.0, 0.0], [len(network.input_scale), network.wheels])
    there, back, still = (
        np.concatenate(next_momentum(network, *parts_of(one, network.wheels)))
        for one in (x, x * (1.0 - 2.0 * causes), x * (1.0 - causes))
    )
    assert np.array_equal(there, -back)
    assert np.abs(there).max() > 0.0
    assert not still.any()


@pytest.mark.parametrize("network", networks())
def test_rotors_at_rest_close_the_gate(network: AppendageNetwork) -> None:
    scales = scale_of(network)
    x = np.random.default_rng(3).standard_normal(len(scales)) * scales
    no_spin = np.repeat([1.0, 0.0], [len(network.input_scale), network.wheels])
    shut = replace(network, B=0.0 * network.B)

    def output(one: AppendageNetwork, x: Array) -> Array:
        return np.concatenate(next_momentum(one, *parts_of(x, network.wheels)))

    ungated, turning = output(shut, x), output(network, x)
    assert np.array_equal(output(network, x * no_spin), ungated)
    back = output(network, x * (2.0 * no_spin - 1.0))
    assert np.allclose(turning + back, 2.0 * ungated, rtol=0.0, atol=1e-12)
    assert bool(network.gates) == bool(np.any(turning != ungated))


def test_growth_is_that_of_the_recursion() -> None:
    network = random_network()
    network = replace(network, W=0.2 * network.W, V=0.2 * network.V, B=0.2 * network.B)
    p = network.spin_scale * np.array([1.0, -0.5])
    tiny, zero = 1e-9 * np.random.default_rng(5).standard_normal((2, 3)), np.zeros(2)
    before, now = tiny
    sizes = []
    for _ in range(400):
        now, before = next_momentum(network, now, before, zero, zero, zero, p)[0], now
        sizes.append(np.linalg.norm(now))
        now, before = now / sizes[-1] * 1e-9, before / sizes[-1] * 1e-9
    rate = np.exp(np.mean(np.log(np.array(sizes[200:]) / 1e-9)))
    assert rate == pytest.approx(spectral_radius(network, p), rel=0.03)
    assert abs(spectral_radius(network, 0.0 * p) - rate) > 0.1 * rate


@pytest.mark.parametrize("network", networks()[-len(SHIPPED) :])
def test_a_shipped_recursion_decays(network: AppendageNetwork) -> None:
    """At rest and turning at the root mean square of the training flights' rates."""
    for way in np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1]]):
        assert 0.5 < spectral_radius(network, way * network.spin_scale) < 1.0
