"""The appendage network as it flies: one function in NumPy, CasADi and torch, odd, decaying."""

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import torch

from control.learned.appendage import AppendageNetwork, advance, growth, symbolic
from learning.appendage_rollout import Appendage
from simsat.appendage_networks import read_appendage, shipped_appendage
from simsat.arrays import Array
from simsat.mjcf import Model, read_model
from simsat.settings import find_model
from tests.appendage_cases import PERIOD, random_network

SHIPPED = ("flexible_panels", "slosh")


def networks() -> list[AppendageNetwork]:
    shipped = []
    for name in SHIPPED:
        path = shipped_appendage(Path(name))
        assert path is not None
        craft = read_model(find_model(Path(name))).spacecraft
        shipped.append(read_appendage(path, craft, PERIOD))
    return [random_network(), random_network(width=0), random_network(wheels=3), *shipped]


def parts_of(x: Array, wheels: int) -> list[Array]:
    """(c, c_before, u, u_before, u_before2) of x (..., 6 + 3 m)."""
    ends = np.cumsum([3, 3, wheels, wheels])
    return np.split(x, ends, axis=-1)


def torch_twin(network: AppendageNetwork, model: Model) -> Appendage:
    scales = (network.input_scale, network.output_scale)
    module = Appendage(model.spacecraft, network.J, scales, network.width)
    for name in ("W", "U", "V"):
        getattr(module, name).data = torch.as_tensor(getattr(network, name))
    return module


@pytest.mark.parametrize("network", networks())
def test_numpy_casadi_and_torch_agree_in_value_and_slope(
    network: AppendageNetwork, two_wheel: Model
) -> None:
    module = torch_twin(network, two_wheel)
    scale = network.output_scale.max()
    inputs = len(network.input_scale)
    slopes = {kind: _casadi_slope(network, kind) for kind in (ca.SX, ca.MX)}
    for x in np.random.default_rng(0).standard_normal((5, inputs)) * network.input_scale:
        tensor = torch.as_tensor(x)
        answer = module(tensor).detach().numpy()
        slope = torch.autograd.functional.jacobian(module, tensor).numpy()
        numbers = np.concatenate(advance(network, *parts_of(x, network.wheels)))
        assert np.abs(numbers - answer).max() < 1e-9 * scale
        for function in slopes.values():
            value, jacobian = (np.array(out) for out in function(x))
            assert np.abs(value.ravel() - answer).max() < 1e-9 * scale
            in_scales = (jacobian - slope) * network.input_scale
            assert np.abs(in_scales).max() < 1e-9 * scale


def _casadi_slope(network: AppendageNetwork, kind: type) -> ca.Function:
    """x -> (output, d output / d x)."""
    x = kind.sym("x", len(network.input_scale))  # type: ignore[attr-defined]
    ends = [0, *np.cumsum([3, 3, *[network.wheels] * 3]).tolist()]
    y = ca.vertcat(*symbolic(network, *ca.vertsplit(x, ends)))
    return ca.Function("slope", [x], [y, ca.jacobian(y, x)])


def test_batches_are_rows() -> None:
    network = random_network()
    x = 0.05 * np.random.default_rng(1).standard_normal((4, 3, 12))
    c, mean = advance(network, *parts_of(x, 2))
    assert c.shape == mean.shape == (4, 3, 3)
    one = advance(network, *parts_of(x[2, 1], 2))
    assert np.allclose(c[2, 1], one[0], rtol=1e-12)
    assert np.allclose(mean[2, 1], one[1], rtol=1e-12)


@pytest.mark.parametrize("network", networks())
def test_it_is_odd_and_nothing_moves_without_a_cause(network: AppendageNetwork) -> None:
    x = np.random.default_rng(2).standard_normal(len(network.input_scale)) * network.input_scale
    there = np.concatenate(advance(network, *parts_of(x, network.wheels)))
    back = np.concatenate(advance(network, *parts_of(-x, network.wheels)))
    assert np.array_equal(there, -back)
    assert np.abs(there).max() > 0.0
    assert not np.concatenate(advance(network, *parts_of(0.0 * x, network.wheels))).any()


def test_growth_is_that_of_the_recursion() -> None:
    network = random_network()
    network = replace(network, W=0.2 * network.W, V=0.2 * network.V)
    tiny, zero = 1e-9 * np.random.default_rng(5).standard_normal((2, 3)), np.zeros(2)
    before, now = tiny
    sizes = []
    for _ in range(400):
        now, before = advance(network, now, before, zero, zero, zero)[0], now
        sizes.append(np.linalg.norm(now))
        now, before = now / sizes[-1] * 1e-9, before / sizes[-1] * 1e-9
    rate = np.exp(np.mean(np.log(np.array(sizes[200:]) / 1e-9)))
    assert rate == pytest.approx(growth(network), rel=0.03)


@pytest.mark.parametrize("network", networks()[3:])
def test_a_shipped_recursion_decays(network: AppendageNetwork) -> None:
    assert 0.5 < growth(network) < 1.0
