"""The roll-out loss: does the recursion predict the body rates over many control periods?

    L = (mean |e_j|^2 / s^2 + mean |ebar_j|^2 / sbar^2 + a mean (n'd_j)^2 / s_n^2
        + a mean (n'dbar_j)^2 / sbar_n^2) / (2 + 2 a)
    d_j = c_hat_{k+j} - c_{k+j},    e_j = J_hub^-1 d_j,    dbar_j and ebar_j of the period's means

The recursion starts from two measured momenta and from then on feeds itself, under the torques that
were commanded and at the spin momenta that were measured, over `horizon` periods. e is the error of
the predicted rates, ebar that of the attitude's increments over the period. Along the unactuated
axis n (the terms with a, where there is one) what swings is small beside the rest, but is taken for
momentum that no wheel can give or take. The scales s are what the errors would be without any
network (c_hat = 0), so that L is then 1. c and J_hub depend on the inertia, which is learned along.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import torch
from torch import Tensor, nn

from simsat.control.ground.arrays import Array, Matrix3
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.appendage import MOMENTA, AppendageNetwork

from .series import Series, inertia_directions

ALONG = 0.01
"""a: more learns the momentum along n sooner and a little better, and the rates worse (measured in
models/flexible_panels/README.md)."""
WEIGHTS = ("W", "U", "V", "E", "G", "B")
Recursion: TypeAlias = Callable[[Tensor, Tensor], Tensor]
"""A recursion: (n, 6 + 3 m) and spin momenta (n, m) -> (n, 6)."""


@dataclass(frozen=True)
class Scales:
    """s_x, s_p and s_y of a network."""

    input: Array
    """Shape (6 + 3 m,)."""
    spin: Array
    """Shape (m,)."""
    output: Array
    """Shape (6,)."""


class Appendage(nn.Module):
    """The network in torch, to train: the same function as `control.model.appendage`, float64."""

    J_0: Tensor
    directions: Tensor
    rotors: Tensor
    input_scale: Tensor
    spin_scale: Tensor
    output_scale: Tensor

    def __init__(
        self, craft: Spacecraft, J_0: Matrix3, scales: Scales, width: int = 0, gates: int = 0
    ):
        """All weights zero."""
        super().__init__()
        tensor = torch.as_tensor
        self.register_buffer("J_0", tensor(J_0))
        self.register_buffer("directions", tensor(inertia_directions(craft.unactuated)))
        self.register_buffer("rotors", tensor((craft.A * craft.Js) @ craft.A.T))
        self.register_buffer("input_scale", tensor(scales.input))
        self.register_buffer("spin_scale", tensor(scales.spin))
        self.register_buffer("output_scale", tensor(scales.output))
        n = craft.unactuated
        self.n = None if n is None else tensor(n)
        inputs = len(scales.input)
        self.inertia = _zeros(len(self.directions))
        self.W = _zeros(MOMENTA, inputs)
        self.U = _zeros(width, inputs)
        self.V = _zeros(MOMENTA, width)
        self.E = _zeros(gates, inputs)
        self.G = _zeros(gates, len(scales.spin))
        self.B = _zeros(MOMENTA, gates)

    def forward(self, x: Tensor, p: Tensor) -> Tensor:
        """(c_{k+1}, mean), Nms, (..., 6), for x = (c_k, c_{k-1}, u_k, u_{k-1}, u_{k-2}), (..., 6 +
        3 m), and the spin momenta p, (..., m)."""
        x = x / self.input_scale
        opened = p / self.spin_scale @ self.G.T
        y = x @ self.W.T + torch.tanh(x @ self.U.T) @ self.V.T
        y = y + (x @ self.E.T * opened) @ self.B.T
        return y * self.output_scale

    @property
    def J(self) -> Tensor:
        """The inertia as learned so far, kg m^2."""
        return self.J_0 + torch.einsum("a,aij->ij", self.inertia, self.directions)

    def to_rate(self) -> Tensor:
        """J_hub^-1."""
        return torch.linalg.inv(self.J - self.rotors)


def _zeros(*shape: int) -> nn.Parameter:
    return nn.Parameter(torch.zeros(shape, dtype=torch.float64))


def as_network(module: Appendage, period: float) -> AppendageNetwork:
    """The trained network as plain arrays."""

    def plain(values: Tensor) -> Array:
        return values.detach().numpy().copy()

    names = ("J", "input_scale", "spin_scale", "output_scale", *WEIGHTS)
    return AppendageNetwork(**{name: plain(getattr(module, name)) for name in names}, period=period)


def as_module(network: AppendageNetwork, craft: Spacecraft, J_0: Matrix3) -> Appendage:
    """The way back: a network in torch, its inertia as numbers beside J_0."""
    scales = Scales(network.input_scale, network.spin_scale, network.output_scale)
    module = Appendage(craft, J_0, scales, network.width, network.gates)
    directions = inertia_directions(craft.unactuated)
    weights = {
        "inertia": np.einsum("aij,ij->a", directions, network.J - J_0),
        **{name: getattr(network, name) for name in WEIGHTS},
    }
    with torch.no_grad():
        for name, values in weights.items():
            getattr(module, name).copy_(torch.as_tensor(values))
    return module


@dataclass(frozen=True)
class Rollouts:
    """Every stretch of `horizon` periods in some flights, (n, ...), as torch tensors.

    The momenta have two earlier entries each, for k - 1 and k; the torques for k - 2 and k - 1.
    """

    c: Tensor
    """Shape (n, horizon + 2, 3)."""
    c_slope: Tensor
    mean: Tensor
    """Shape (n, horizon, 3)."""
    mean_slope: Tensor
    torque: Tensor
    """Shape (n, horizon + 2, m)."""
    spin: Tensor
    """Shape (n, horizon, m)."""
    noise: Tensor
    """Added to the two momenta a roll-out starts from, Nms, shape (n, 2, 3)."""

    @property
    def horizon(self) -> int:
        """Control periods rolled out."""
        return int(self.mean.shape[1])


def build_rollouts(series: Series, horizon: int, noise: float, seed: int) -> Rollouts:
    """All roll-outs of the flights; before a flight everything was at rest.

    `noise` (Nms, 1 sigma, seeded) is what a momentum measured in flight is wrong by: without it
    the weights would lean on components of c that no gyro resolves.
    """

    random = np.random.default_rng((seed, 17))
    n = series.flights * (series.mean.shape[1] - horizon + 1)
    return Rollouts(
        c=_stretches(series.c, horizon + 2, 1),
        c_slope=_stretches(series.c_slope, horizon + 2, 1),
        mean=_stretches(series.mean, horizon, 0),
        mean_slope=_stretches(series.mean_slope, horizon, 0),
        torque=_stretches(series.torque, horizon + 2, 2),
        spin=_stretches(series.spin, horizon, 0),
        noise=torch.as_tensor(noise * random.standard_normal((n, 2, 3))),
    )


def _stretches(values: Array, length: int, before: int) -> Tensor:
    """All runs of so many entries of the second axis, zeros before its first: (n, length, ...)."""
    rest = np.zeros((len(values), before, *values.shape[2:]))
    padded = np.concatenate([rest, values], axis=1)
    runs = np.lib.stride_tricks.sliding_window_view(padded, length, axis=1)
    runs = np.moveaxis(runs, -1, 2)
    return torch.as_tensor(runs.reshape(-1, *runs.shape[2:]).copy())


def roll_out(recursion: Recursion, rollouts: Rollouts, c: Tensor) -> tuple[Tensor, Tensor]:
    """Predicted momenta and means, Nms, each (n, horizon, 3), from the first two of c (n, ., 3)."""
    start = c[:, :2] + rollouts.noise
    before, now = start[:, 0], start[:, 1]
    ends, means = [], []
    for j in range(rollouts.horizon):
        u = rollouts.torque[:, j : j + 3].flip(1).flatten(1)
        y = recursion(torch.cat([now, before, u], dim=-1), rollouts.spin[:, j])
        before, now = now, y[:, :3]
        ends.append(now)
        means.append(y[:, 3:])
    return torch.stack(ends, dim=1), torch.stack(means, dim=1)


def momentum_errors(
    module: Appendage, rollouts: Rollouts, recursion: Recursion | None = None
) -> tuple[Tensor, Tensor]:
    """Of c and of its mean, Nms, each (n, horizon, 3); `recursion` in place of the module's own
    recursion."""
    c = rollouts.c + rollouts.c_slope @ module.inertia
    mean = rollouts.mean + rollouts.mean_slope @ module.inertia
    ends, means = roll_out(recursion or module, rollouts, c)
    return ends - c[:, 2:], means - mean


def rate_errors(
    module: Appendage, rollouts: Rollouts, recursion: Recursion | None = None
) -> tuple[Tensor, Tensor]:
    """e and ebar, rad/s, each (n, horizon, 3)."""
    end, mean = momentum_errors(module, rollouts, recursion)
    back = module.to_rate().T
    return end @ back, mean @ back


def mean_squares(
    module: Appendage, rollouts: Rollouts, recursion: Recursion | None = None
) -> Tensor:
    """Mean of |e|^2 and of |ebar|^2, then with an unactuated axis n of the momenta's errors along
    it, (n'J_hub e)^2 and (n'J_hub ebar)^2: shape (2,) or (4,)."""
    errors = momentum_errors(module, rollouts, recursion)
    back = module.to_rate().T
    squares = [((error @ back) ** 2).sum(dim=-1).mean() for error in errors]
    if module.n is not None:
        squares += [((error @ module.n) ** 2).mean() for error in errors]
    return torch.stack(squares)


@dataclass(frozen=True)
class Loss:
    """The roll-out loss of some flights; `scale` is what divides each of `mean_squares`."""

    rollouts: Rollouts
    scale: Tensor

    def __call__(self, module: Appendage) -> Tensor:
        """L."""
        return (mean_squares(module, self.rollouts) / self.scale).sum()


def loss_scale(module: Appendage, rollouts: Rollouts) -> Tensor:
    """Mean squares without a network, for the inertia as the module has it, over their weights."""
    with torch.no_grad():
        squares = mean_squares(module, rollouts, without_network)
    weights = torch.tensor([1.0, 1.0, ALONG, ALONG], dtype=squares.dtype)[: len(squares)]
    return squares / weights * weights.sum()


def without_network(x: Tensor, p: Tensor) -> Tensor:
    """The recursion that says c = 0."""
    return torch.zeros_like(x[..., :MOMENTA])
