"""The roll-out loss: does the recursion predict the body rates over many control periods?

    L = 1/2 mean |e_j|^2 / s^2 + 1/2 mean |ebar_j|^2 / sbar^2
    e_j = J_hub^-1 (c_hat_{k+j} - c_{k+j}),    ebar_j likewise with the means over the periods

The recursion starts from two measured momenta and from then on feeds itself, under the torques that
were commanded, over `horizon` periods. e is the error of the predicted rates, ebar that of the
attitude's increments over the period; s and sbar are what they would be without any network
(c_hat = 0), so that L is then 1. c and J_hub depend on the inertia, which is learned along.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from control.learned.appendage import MOMENTA, AppendageNetwork
from learning.appendage_series import Series, inertia_directions
from simsat.arrays import Array, Matrix3
from simsat.spacecraft import Spacecraft


class Appendage(nn.Module):
    """The network in torch, to train: the same function as `control.learned.appendage`, float64."""

    J_0: Tensor
    directions: Tensor
    rotors: Tensor
    input_scale: Tensor
    output_scale: Tensor

    def __init__(self, craft: Spacecraft, J_0: Matrix3, scales: tuple[Array, Array], width: int):
        """All weights zero; `scales` are s_x and s_y."""
        super().__init__()
        tensor = torch.as_tensor
        self.register_buffer("J_0", tensor(J_0))
        self.register_buffer("directions", tensor(inertia_directions(craft.unactuated)))
        self.register_buffer("rotors", tensor((craft.A * craft.Js) @ craft.A.T))
        self.register_buffer("input_scale", tensor(scales[0]))
        self.register_buffer("output_scale", tensor(scales[1]))
        inputs = len(scales[0])
        self.inertia = nn.Parameter(torch.zeros(len(self.directions), dtype=torch.float64))
        self.W = nn.Parameter(torch.zeros(MOMENTA, inputs, dtype=torch.float64))
        self.U = nn.Parameter(torch.zeros(width, inputs, dtype=torch.float64))
        self.V = nn.Parameter(torch.zeros(MOMENTA, width, dtype=torch.float64))

    def forward(self, x: Tensor) -> Tensor:
        """(c_{k+1}, mean), Nms, (..., 6), for (c_k, c_{k-1}, u_k, u_{k-1}, u_{k-2}), (..., n)."""
        x = x / self.input_scale
        y = x @ self.W.T + torch.tanh(x @ self.U.T) @ self.V.T
        return y * self.output_scale

    @property
    def J(self) -> Tensor:
        """The inertia as learned so far, kg m^2."""
        return self.J_0 + torch.einsum("a,aij->ij", self.inertia, self.directions)

    def to_rate(self) -> Tensor:
        """J_hub^-1."""
        return torch.linalg.inv(self.J - self.rotors)


def as_network(module: Appendage, period: float) -> AppendageNetwork:
    """The trained network as plain arrays."""

    def plain(values: Tensor) -> Array:
        return values.detach().numpy().copy()

    names = ("J", "input_scale", "output_scale", "W", "U", "V")
    return AppendageNetwork(**{name: plain(getattr(module, name)) for name in names}, period=period)


def as_module(network: AppendageNetwork, craft: Spacecraft, J_0: Matrix3) -> Appendage:
    """The way back: a network in torch, its inertia as numbers beside J_0."""
    scales = (network.input_scale, network.output_scale)
    module = Appendage(craft, J_0, scales, network.width)
    directions = inertia_directions(craft.unactuated)
    weights = {
        "inertia": np.einsum("aij,ij->a", directions, network.J - J_0),
        **{name: getattr(network, name) for name in ("W", "U", "V")},
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
        noise=torch.as_tensor(noise * random.standard_normal((n, 2, 3))),
    )


def _stretches(values: Array, length: int, before: int) -> Tensor:
    """All runs of so many entries of the second axis, zeros before its first: (n, length, ...)."""
    rest = np.zeros((len(values), before, *values.shape[2:]))
    padded = np.concatenate([rest, values], axis=1)
    runs = np.lib.stride_tricks.sliding_window_view(padded, length, axis=1)
    runs = np.moveaxis(runs, -1, 2)
    return torch.as_tensor(runs.reshape(-1, *runs.shape[2:]).copy())


def roll_out(
    step: Callable[[Tensor], Tensor], rollouts: Rollouts, c: Tensor
) -> tuple[Tensor, Tensor]:
    """Predicted momenta and means, Nms, each (n, horizon, 3), from the first two of c (n, ., 3).

    `step` is the recursion: (n, 6 + 3 m) -> (n, 6).
    """
    start = c[:, :2] + rollouts.noise
    before, now = start[:, 0], start[:, 1]
    ends, means = [], []
    for j in range(rollouts.horizon):
        u = rollouts.torque[:, j : j + 3].flip(1).flatten(1)
        y = step(torch.cat([now, before, u], dim=-1))
        before, now = now, y[:, :3]
        ends.append(now)
        means.append(y[:, 3:])
    return torch.stack(ends, dim=1), torch.stack(means, dim=1)


def rate_errors(
    module: Appendage, rollouts: Rollouts, step: Callable[[Tensor], Tensor] | None = None
) -> tuple[Tensor, Tensor]:
    """e and ebar, rad/s, each (n, horizon, 3); `step` in place of the module's own recursion."""
    c = rollouts.c + rollouts.c_slope @ module.inertia
    mean = rollouts.mean + rollouts.mean_slope @ module.inertia
    ends, means = roll_out(step or module, rollouts, c)
    back = module.to_rate().T
    return (ends - c[:, 2:]) @ back, (means - mean) @ back


def mean_square(error: Tensor) -> Tensor:
    """Mean of |e|^2."""
    return (error**2).sum(dim=-1).mean()


@dataclass(frozen=True)
class Loss:
    """The roll-out loss of some flights; `scale` is (s^2, sbar^2)."""

    rollouts: Rollouts
    scale: tuple[float, float]

    def __call__(self, module: Appendage) -> Tensor:
        """L."""
        end, mean = (mean_square(error) for error in rate_errors(module, self.rollouts))
        return 0.5 * (end / self.scale[0] + mean / self.scale[1])


def loss_scale(module: Appendage, rollouts: Rollouts) -> tuple[float, float]:
    """(s^2, sbar^2): mean squares without a network, for the inertia as the module has it."""
    with torch.no_grad():
        errors = rate_errors(module, rollouts, without_network)
    return float(mean_square(errors[0])), float(mean_square(errors[1]))


def without_network(x: Tensor) -> Tensor:
    """The recursion that says c = 0."""
    return torch.zeros_like(x[..., :MOMENTA])
