"""The network in torch, to train: the same function as `control.network.Network`, in float64."""

from itertools import pairwise

import numpy as np
import torch
from torch import Tensor, nn

from simsat.control.correction.network import Network
from simsat.control.ground.arrays import Array


class Pinn(nn.Module):
    """Fully connected tanh layers between a normalisation and a bounded output."""

    mean: Tensor
    scale: Tensor

    def __init__(self, mean: Array, scale: Array, widths: tuple[int, ...], bound: float):
        """`widths` lists hidden layers and outputs; `bound` (Nm) is what the output can't pass."""
        super().__init__()
        self.register_buffer("mean", torch.as_tensor(mean))
        self.register_buffer("scale", torch.as_tensor(scale))
        self.bound = bound
        sizes = (len(mean), *widths)
        self.layers = nn.ModuleList(
            nn.Linear(a, b, dtype=torch.float64) for a, b in pairwise(sizes)
        )

    def forward(self, x: Tensor) -> Tensor:
        """Residual torque on the wheel axes, Nm, for inputs (..., inputs)."""
        h = (x - self.mean) / self.scale
        for layer in self.layers:
            h = torch.tanh(layer(h))
        return self.bound * h


def build_pinn(x: Array, outputs: int, hidden: tuple[int, ...], bound: float, seed: int) -> Pinn:
    """A network for inputs distributed like x (n, inputs), with seeded first weights.

    An input that never varies gets scale 1: it carries nothing to learn from.
    """
    mean, spread = x.mean(axis=0), x.std(axis=0)
    scale = np.where(spread > 1e-12 * (1.0 + np.abs(mean)), spread, 1.0)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return Pinn(mean, scale, (*hidden, outputs), bound)


def as_network(pinn: Pinn) -> Network:
    """The trained network as plain arrays."""
    layers = [layer for layer in pinn.layers if isinstance(layer, nn.Linear)]
    return Network(
        mean=pinn.mean.numpy().copy(),
        scale=pinn.scale.numpy().copy(),
        weights=tuple(layer.weight.detach().numpy().copy() for layer in layers),
        biases=tuple(layer.bias.detach().numpy().copy() for layer in layers),
        bound=pinn.bound,
    )
