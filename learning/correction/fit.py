"""Training: one epoch at a time, from a state that can be saved between any two of them."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

import numpy as np
import torch

from simsat.control.correction.network import Network
from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.own import Own, own
from simsat.control.ground.settings import Count, CountOrNone, Positive, Settings
from simsat.control.model.rates import RateModel

from ..progress import FitState, best_module, note_epoch, open_round
from ..progress import unpack as unpack_into
from ..sequence import self_fed
from .pinn import Pinn, as_network
from .rollout import Problem, build_problem, residual_scale, rollout_loss
from .windows import Windows, shifted


@dataclass(frozen=True)
class FitSettings(Settings, group="fit"):
    """How the network is trained."""

    epochs: Count = 120
    """Longest round, in passes over the training windows."""
    teacher_epochs: CountOrNone = 20
    """Passes of the first round in which the previous estimate is the true one; later it is the
    network's own, as in flight."""
    patience: Count = 30
    """Passes without progress on the held-out flights after which a round ends."""
    batch: Count = 128
    """Windows per step of the optimiser."""
    learning_rate: Positive = 3e-3
    """Adam's at the start; it falls to a hundredth along half a cosine. A later round starts at a
    third of it, so as not to unlearn."""
    hidden: tuple[Count, ...] = (128, 128, 128)
    """Widths of the hidden layers."""
    bound_Nm: Annotated[Positive | None, Own("torque", 0.015)] = None
    """Largest torque that the network can express, Nm per wheel; 0.015 in the craft's own units, as
    the correction's limit, unless given."""

    @property
    def bound(self) -> float:
        """Largest torque that the network can express."""
        return own(self, "bound_Nm")

    def check(self) -> None:
        """The network has a layer."""
        if not self.hidden:
            raise SettingsError("--fit.hidden is empty: give the width of at least one layer")


PinnState: TypeAlias = FitState[Pinn]


@dataclass(frozen=True)
class RoundData:
    """A round's data."""

    believed: RateModel
    training: Windows
    held_out: Windows
    training_problem: Problem
    held_out_problem: Problem


def build_round_data(training: Windows, held_out: Windows, believed: RateModel) -> RoundData:
    """A round on some flights, judged on others."""
    scale = residual_scale(training)
    return RoundData(
        believed,
        training,
        held_out,
        build_problem(training, believed, scale),
        build_problem(held_out, believed, scale),
    )


def start(pinn: Pinn, settings: FitSettings) -> PinnState:
    """The state before the first epoch."""
    return FitState(pinn, _adam(pinn, settings))


def next_round(state: PinnState, settings: FitSettings) -> None:
    """Go on from this round's best weights with a fresh optimiser."""
    pinn = best_module(state)
    open_round(state, pinn, _adam(pinn, settings))


def run_epoch(state: PinnState, data: RoundData, settings: FitSettings, seed: int) -> None:
    """One pass over the training windows, then the held-out loss, self-fed as in flight.

    The order of the windows follows from seed, round and epoch alone.
    """
    x = torch.as_tensor(_inputs(state, data, settings))
    random = np.random.default_rng((seed, state.round, state.epoch))
    order = torch.as_tensor(random.permutation(len(x)))
    for group in state.optimizer.param_groups:
        group["lr"] = _learning_rate(state.round, state.epoch, settings)
    total = 0.0
    for rows in order.split(settings.batch):
        state.optimizer.zero_grad()
        loss = rollout_loss(data.training_problem, state.module(x[rows]), rows)
        loss.backward()
        state.optimizer.step()
        total += float(loss.detach()) * len(rows)
    held_out = held_out_loss(as_network(state.module), data)
    note_epoch(state, total / len(x), held_out, settings.epochs, settings.patience)


def best_network(state: PinnState) -> Network:
    """The round's best weights as a plain network."""
    return as_network(best_module(state))


def _inputs(state: PinnState, data: RoundData, settings: FitSettings) -> Array:
    """Features (n, inputs) of the training windows, teacher-forced at first, then self-fed."""
    windows = data.training
    if state.round == 1 and state.epoch < settings.teacher_epochs:
        estimates = windows.residual
    else:
        estimates = self_fed(as_network(state.module), windows, data.believed)
    x = windows.features(shifted(estimates), data.believed)
    return x.reshape(-1, x.shape[-1])


def held_out_loss(network: Network, data: RoundData) -> float:
    """L over the held-out flights, self-fed."""
    windows, problem = data.held_out, data.held_out_problem
    estimates = self_fed(network, windows, data.believed)
    tau_hat = torch.as_tensor(estimates.reshape(-1, estimates.shape[-1]))
    with torch.no_grad():
        return float(rollout_loss(problem, tau_hat, torch.arange(len(tau_hat))))


def _learning_rate(number: int, epoch: int, settings: FitSettings) -> float:
    start = settings.learning_rate if number == 1 else settings.learning_rate / 3.0
    fall = 0.5 * (1.0 + math.cos(math.pi * epoch / settings.epochs))
    return start * (0.01 + 0.99 * fall)


def _adam(pinn: Pinn, settings: FitSettings) -> torch.optim.Adam:
    return torch.optim.Adam(pinn.parameters(), lr=settings.learning_rate)


def unpack(checkpoint: dict[str, Any], pinn: Pinn, settings: FitSettings) -> PinnState:
    """The state from a checkpoint and a network of the same shape."""
    return unpack_into(checkpoint, start(pinn, settings))
