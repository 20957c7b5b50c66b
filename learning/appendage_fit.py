"""Training of an appendage network: first the linear part and J, then the tanh layer with them.

All roll-outs go into every step: there are few numbers and few flights, so that L-BFGS with a line
search gets in seconds where Adam doesn't in minutes, and nothing is drawn at random on the way.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import torch
from torch import Tensor

from learning.appendage_linear import build_appendage, widened
from learning.appendage_rollout import (
    Appendage,
    Loss,
    build_rollouts,
    loss_scale,
)
from learning.appendage_series import Series
from learning.progress import FitState, best_module, note_epoch, open_round
from simsat.arrays import Matrix3
from simsat.errors import SettingsError, require
from simsat.spacecraft import Spacecraft

HISTORY = 20  # steps that L-BFGS remembers

AppendageState: TypeAlias = FitState[Appendage]


@dataclass(frozen=True)
class AppendageFitSettings:
    """How an appendage network is trained."""

    width: int = 16
    """Width of the tanh layer; 0 trains the linear part alone."""
    horizon: int = 12
    """Control periods that a roll-out lasts. Longer weighs frequency and damping more, shorter the
    first period."""
    epochs: int = 60
    """Longest round, in epochs."""
    iterations: int = 20
    """Steps of L-BFGS in an epoch."""
    patience: int = 10
    """Epochs without progress on the held-out flights after which a round ends."""
    rate_noise: float = 1e-5
    """What the rates that c is measured from are taken to be wrong by, rad/s (1 sigma). More keeps
    the weights from leaning on small components of c, less predicts better without noise."""

    def __post_init__(self) -> None:
        require(self, "fit", "width rate_noise", 0.0)
        require(self, "fit", "horizon epochs iterations patience", 1.0)


@dataclass(frozen=True)
class Fleet:
    """The flights, split by whole flights."""

    training: Series
    held_out: Series
    """For early stopping."""
    unseen: Series
    """For the report alone."""


@dataclass(frozen=True)
class Course:
    """What a training runs on: where it starts, and its losses."""

    first: Appendage
    """Linear, by least squares."""
    training: Loss
    held_out: Loss


def build_course(
    fleet: Fleet, craft: Spacecraft, J_0: Matrix3, settings: AppendageFitSettings, seed: int
) -> Course:
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
    return Course(first, Loss(training, scale), Loss(held_out, scale))


def momentum_noise(settings: AppendageFitSettings, J_0: Matrix3) -> float:
    """What a measured c is taken to be wrong by, Nms."""
    return settings.rate_noise * float(J_0.trace()) / 3.0


def start(module: Appendage, settings: AppendageFitSettings) -> AppendageState:
    """The state before the first epoch."""
    return FitState(module, _optimizer(module, settings))


def blank(
    number: int, course: Course, craft: Spacecraft, settings: AppendageFitSettings
) -> AppendageState:
    """A state of the shape that a round has: the first is linear, the second has the tanh layer."""
    first = copy.deepcopy(course.first)
    module = first if number == 1 else widened(first, craft, settings.width, 0)
    return start(module, settings)


def next_round(
    state: AppendageState, craft: Spacecraft, settings: AppendageFitSettings, seed: int
) -> None:
    """Go on from the best linear network with a tanh layer that hardly speaks yet."""
    module = widened(best_module(state), craft, settings.width, seed)
    open_round(state, module, _optimizer(module, settings))


def run_epoch(state: AppendageState, course: Course, settings: AppendageFitSettings) -> None:
    """Some steps of L-BFGS on all training roll-outs, then the held-out loss."""
    training = float(state.optimizer.step(_closure(state, course.training)))
    with torch.no_grad():
        held_out = float(course.held_out(state.module))
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
