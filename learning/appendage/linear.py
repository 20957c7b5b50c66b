"""Where training starts: scales, the least squares of one step, and first weights of the layers."""

import copy

import numpy as np
import torch
from torch import nn

from simsat.control.ground.arrays import Array, Matrix3
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.appendage import MOMENTA

from .rollout import Appendage, Scales
from .series import Series, fit_inertia

FIRST_OUTWARD = 1e-3  # of V and B, in scales: small, so that a new layer starts almost unheard


def scales(series: Series, d: Array) -> Scales:
    """Root mean squares, one for all components of c, one for all torques and one for all spin
    momenta, because what a measurement is wrong by is as large in each."""
    c = float(np.sqrt(np.mean((series.c + series.c_slope @ d) ** 2)))
    u = float(np.sqrt(np.mean(series.torque**2)))
    p = float(np.sqrt(np.mean(series.spin**2)))
    m = series.torque.shape[-1]
    return Scales(np.repeat([c, u], [6, 3 * m]), np.repeat(p, m), np.repeat(c, 6))


def build_appendage(series: Series, craft: Spacecraft, J_0: Matrix3, noise: float) -> Appendage:
    """A linear network by least squares: J over all samples, then W over single steps.

    `noise` (Nms, 1 sigma) of the measured momenta keeps W from leaning on what is below it.
    """
    d = fit_inertia(series)
    module = Appendage(craft, J_0, scales(series, d))
    x, y = one_step(series, d)
    x, y = x / module.input_scale.numpy(), y / module.output_scale.numpy()
    ridge = np.zeros(x.shape[-1])
    ridge[:6] = len(x) * (noise / module.input_scale.numpy()[:6]) ** 2
    W = np.linalg.lstsq(x.T @ x + np.diag(ridge), x.T @ y, rcond=None)[0].T
    with torch.no_grad():
        module.inertia.copy_(torch.as_tensor(d))
        module.W.copy_(torch.as_tensor(W))
    return module


def one_step(series: Series, d: Array) -> tuple[Array, Array]:
    """Inputs (n, 6 + 3 m) and outputs (n, 6) of every period, for the inertia's numbers d."""
    c = np.pad(series.c + series.c_slope @ d, ((0, 0), (1, 0), (0, 0)))
    u = np.pad(series.torque, ((0, 0), (2, 0), (0, 0)))
    mean = series.mean + series.mean_slope @ d
    x = np.concatenate([c[:, 1:-1], c[:, :-2], u[:, 2:], u[:, 1:-1], u[:, :-2]], axis=-1)
    y = np.concatenate([c[:, 2:], mean], axis=-1)
    return x.reshape(-1, x.shape[-1]), y.reshape(-1, y.shape[-1])


def with_tanh(module: Appendage, width: int, seed: int) -> Appendage:
    """The same network with a tanh layer of so many units, which hardly speaks yet."""
    return _with(module, {"U": (width, module.W.shape[1])}, "V", seed)


def with_gate(module: Appendage, gates: int, seed: int) -> Appendage:
    """The same network with so many gates, which hardly open yet."""
    inward = {"E": (gates, module.W.shape[1]), "G": (gates, len(module.spin_scale))}
    return _with(module, inward, "B", seed)


def _with(
    module: Appendage, inward: dict[str, tuple[int, int]], outward: str, seed: int
) -> Appendage:
    """A layer's weights drawn at random: inward of size one in all, outward small."""
    random = np.random.default_rng((seed, 3))
    wider = copy.deepcopy(module)
    units = 0
    for name, shape in inward.items():
        units = shape[0]
        values = random.standard_normal(shape) / np.sqrt(shape[1])
        setattr(wider, name, nn.Parameter(torch.as_tensor(values)))
    values = FIRST_OUTWARD * random.standard_normal((MOMENTA, units))
    setattr(wider, outward, nn.Parameter(torch.as_tensor(values)))
    return wider
