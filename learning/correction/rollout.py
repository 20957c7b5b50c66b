"""The physics-informed loss: does the nominal model with the estimated torque predict the rates?

    L = mean |G^+ (omega_hat_{k+H}(theta) - omega_{k+H})|^2 / s^2,    G = T_s J_hub^-1 A

omega_hat is rolled out from the measured state by H Runge-Kutta steps of the nominal model under
tau_hat, held over the window: the loss sees theta only through the dynamics. Source: the paper's
equation (2), which is the case G^+ = 1, s = 1. Two things differ:

* G^+ expresses the rate error as the torque on the wheel axes that would explain it. The rest no
  wheel can correct, but it is as large; left in, the optimum spends wheel torque on it (through the
  gyroscopic coupling) and predicts the wheel axes three times worse (docs/network.md).
* s^2 is the mean square of the missed torque over the training windows: raw values are near 1e-7,
  where Adam's epsilon would swallow the gradient. The nominal model has L near 1.
"""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from simsat.control.ground.arrays import Array
from simsat.control.model.rates import RateModel, predict_rate, rate_effect

from .windows import Windows


@dataclass(frozen=True)
class Problem:
    """Windows as torch tensors, flattened to (n, ...), and the model to roll them out with."""

    model: RateModel
    omega: Tensor
    wheel_speed: Tensor
    torques: Tensor
    omega_after: Tensor
    to_torque: Tensor
    """G^+ / s, shape (m, 3)."""
    period: float


def as_tensors(model: RateModel) -> RateModel:
    """The same model in torch."""
    tensor, friction = torch.as_tensor, model.friction
    return RateModel(
        tensor(model.J),
        tensor(model.A),
        tensor(model.Js),
        tensor(model.J_hub_inverse),
        None if friction is None else (tensor(friction[0]), tensor(friction[1])),
    )


def residual_scale(windows: Windows) -> float:
    """s of the loss: root mean square of the torque that the nominal model misses, Nm."""
    return float(np.sqrt(np.mean(np.sum(windows.residual**2, axis=-1))))


def build_problem(windows: Windows, believed: RateModel, scale: float) -> Problem:
    """The loss's data; `scale` is s, Nm."""

    def flat(values: Array) -> Tensor:
        return torch.as_tensor(values.reshape(-1, *values.shape[2:]))

    return Problem(
        as_tensors(believed),
        flat(windows.omega),
        flat(windows.wheel_speed),
        flat(windows.torques),
        flat(windows.omega_after),
        torch.as_tensor(np.linalg.pinv(rate_effect(believed, windows.period)) / scale),
        windows.period,
    )


def rate_error(problem: Problem, tau_hat: Tensor, rows: Tensor) -> Tensor:
    """Predicted minus measured rates at the end of some windows, rad/s, shape (n, 3).

    tau_hat (n, m) is the estimate for these windows on the wheel axes, Nm.
    """
    predicted = predict_rate(
        problem.model,
        problem.omega[rows],
        problem.wheel_speed[rows],
        problem.torques[rows],
        tau_hat @ problem.model.A.T,
        problem.period,
    )
    return predicted - problem.omega_after[rows]


def rollout_loss(problem: Problem, tau_hat: Tensor, rows: Tensor) -> Tensor:
    """L over some windows."""
    error = rate_error(problem, tau_hat, rows) @ problem.to_torque.T
    return (error**2).sum(dim=-1).mean()
