"""Training of an appendage network: first the linear part and J, then a layer at a time with them.

All roll-outs go into every step: there are few numbers and few flights, so that L-BFGS with a line
search gets in seconds where Adam doesn't in minutes, and nothing is drawn at random on the way.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import torch
from torch import Tensor

from simsat.control.ground.arrays import Matrix3
from simsat.control.ground.errors import SettingsError
from simsat.control.ground.settings import Count, CountOrNone, NotNegative, Settings
from simsat.control.ground.spacecraft import Spacecraft

from ..progress import FitState, note_epoch
from .linear import build_appendage, with_gate, with_tanh
from .rollout import (
    Appendage,
    Loss,
    build_rollouts,
    loss_scale,
)
from .series import Series

LINEAR, GATE, TANH = "linear", "gate", "tanh"
LEAST_CUT = 0.05  # of the held-out loss, for which a layer is kept: below, it is noise
HISTORY = 20  # steps that L-BFGS remembers

AppendageState: TypeAlias = FitState[Appendage]


@dataclass(frozen=True)
class AppendageFitSettings(Settings, group="fit"):
    """How an appendage network is trained."""

    width: CountOrNone = 16
    """Width of the tanh layer; 0 trains without."""
    gates: CountOrNone = 4
    """Products of deflection and rotation; 0 trains without."""
    horizon: Count = 12
    """Control periods that a roll-out lasts. Longer weighs frequency and damping more, shorter the
    first period."""
    epochs: Count = 60
    """Longest round, in epochs."""
    iterations: Count = 20
    """Steps of L-BFGS in an epoch."""
    patience: Count = 10
    """Epochs without progress on the held-out flights after which a round ends."""
    rate_noise: NotNegative = 1e-5
    """What the rates that c is measured from are taken to be wrong by, rad/s (1 sigma). More keeps
    the weights from leaning on small components of c, less predicts better without noise."""


@dataclass(frozen=True)
class Fleet:
    """The flights, split by whole flights."""

    training: Series
    held_out: Series
    """For early stopping."""
    unseen: Series
    """For the report alone."""


@dataclass(frozen=True)
class TrainedLayer:
    """What a round came to."""

    layer: str
    module: Appendage
    loss: float
    """Held-out, with the layer."""
    before: float
    """And without."""
    curves: list[dict[str, float]]

    @property
    def kept(self) -> bool:
        """Whether the layer stays; the linear one does."""
        return self.layer == LINEAR or self.loss < (1.0 - LEAST_CUT) * self.before


@dataclass(frozen=True)
class TrainingProblem:
    """What a training runs on: where it starts, and its losses."""

    first: Appendage
    """Linear, by least squares."""
    training: Loss
    held_out: Loss

    def held_out_loss(self, module: Appendage) -> float:
        """Of a module, without its slope."""
        with torch.no_grad():
            return float(self.held_out(module))


def build_training_problem(
    fleet: Fleet, craft: Spacecraft, J_0: Matrix3, settings: AppendageFitSettings, seed: int
) -> TrainingProblem:
    """The losses of some flights, and the least squares that training starts from."""
    periods = fleet.training.mean.shape[1]
    if periods < settings.horizon:
        raise SettingsError(
            f"--fit.horizon is {settings.horizon} periods, but the flights have {periods}"
        )
    noise = momentum_noise(settings, J_0)
    first = build_appendage(fleet.training, craft, J_0, noise)
    training = build_rollouts(fleet.training, settings.horizon, noise, seed)
    held_out = build_rollouts(fleet.held_out, settings.horizon, noise, seed + 1)
    scale = loss_scale(first, training)
    return TrainingProblem(first, Loss(training, scale), Loss(held_out, scale))


def momentum_noise(settings: AppendageFitSettings, J_0: Matrix3) -> float:
    """What a measured c is taken to be wrong by, Nms."""
    return settings.rate_noise * float(J_0.trace()) / 3.0


def layers_to_train(settings: AppendageFitSettings) -> list[str]:
    """What is learned round by round, each with all before it that was kept.

    The gate goes first: what it explains is the larger part, which the tanh layer would bend to.
    """
    sizes = {LINEAR: 1, GATE: settings.gates, TANH: settings.width}
    return [name for name, size in sizes.items() if size]


def begin(
    number: int, layer: str, before: Appendage, settings: AppendageFitSettings, seed: int
) -> AppendageState:
    """The state before the first epoch of a round: what was learned before, and a new layer that
    hardly speaks yet."""
    if layer == TANH:
        module = with_tanh(before, settings.width, seed)
    elif layer == GATE:
        module = with_gate(before, settings.gates, seed)
    else:
        module = copy.deepcopy(before)
    return FitState(module, _optimizer(module, settings), round=number)


def run_epoch(
    state: AppendageState, problem: TrainingProblem, settings: AppendageFitSettings
) -> None:
    """Some steps of L-BFGS on all training roll-outs, then the held-out loss."""
    training = float(state.optimizer.step(_closure(state, problem.training)))
    held_out = problem.held_out_loss(state.module)
    note_epoch(state, training, held_out, settings.epochs, settings.patience)


def _closure(state: AppendageState, loss: Loss) -> Callable[[], Tensor]:
    def evaluate() -> Tensor:
        state.optimizer.zero_grad()
        value = loss(state.module)
        value.backward()
        return value.detach()

    return evaluate


def _optimizer(module: Appendage, settings: AppendageFitSettings) -> torch.optim.LBFGS:
    return torch.optim.LBFGS(
        module.parameters(),
        max_iter=settings.iterations,
        history_size=HISTORY,
        line_search_fn="strong_wolfe",
    )
