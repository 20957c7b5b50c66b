"""How far a training has come: a state that can be saved between any two epochs."""

import copy
import io
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

import torch
from torch import Tensor
from tqdm import tqdm

from simsat.control.ground.errors import OutputError
from simsat.results.files import write_bytes

CHECKPOINT = "checkpoint.pt"
INTERRUPTED = 3  # exit code of a training that was interrupted and can go on

Module = TypeVar("Module")
"""The kind of torch module that is trained."""


@dataclass
class FitState(Generic[Module]):
    """Everything that the next epoch depends on."""

    module: Module
    optimizer: Any
    """Of torch."""
    round: int = 1
    epoch: int = 0
    """Epochs of this round that are done."""
    best: dict[str, Tensor] = field(default_factory=dict)
    """Weights with the smallest held-out loss of this round."""
    best_loss: float = math.inf
    best_epoch: int = 0
    finished: bool = False
    """This round is over."""
    curves: list[dict[str, float]] = field(default_factory=list)
    """Per epoch: round, epoch, training and held-out loss."""


def note_epoch(
    state: FitState, training: float, held_out: float, epochs: int, patience: int
) -> None:
    """Write down an epoch's losses; the round ends after so many epochs, or without progress on the
    held-out flights over `patience` of them."""
    state.epoch += 1
    state.curves.append(
        {
            "round": state.round,
            "epoch": state.epoch,
            "training_loss": training,
            "held_out_loss": held_out,
        }
    )
    if held_out < state.best_loss:
        state.best = copy.deepcopy(state.module.state_dict())
        state.best_loss, state.best_epoch = held_out, state.epoch
    waited = state.epoch - state.best_epoch
    state.finished = state.epoch >= epochs or waited >= patience


def open_round(state: FitState[Module], module: Module, optimizer: Any) -> None:
    """Begin the next round with this module."""
    state.module, state.optimizer = module, optimizer
    state.round, state.epoch, state.finished = state.round + 1, 0, False
    state.best, state.best_loss, state.best_epoch = {}, math.inf, 0


def best_module(state: FitState[Module]) -> Module:
    """The module with the round's best weights."""
    module: Any = copy.deepcopy(state.module)
    module.load_state_dict(state.best)
    return module


def pack(state: FitState) -> dict[str, Any]:
    """The state as a checkpoint."""
    return {
        "module": state.module.state_dict(),
        "optimizer": state.optimizer.state_dict(),
        **{name: getattr(state, name) for name in PLAIN},
    }


def unpack(checkpoint: dict[str, Any], fresh: FitState[Module]) -> FitState[Module]:
    """The state from a checkpoint and a fresh one of the same shape, which it fills."""
    module: Any = fresh.module
    module.load_state_dict(checkpoint["module"])
    fresh.optimizer.load_state_dict(checkpoint["optimizer"])
    for name in PLAIN:
        setattr(fresh, name, checkpoint[name])
    return fresh


PLAIN = ("round", "epoch", "best", "best_loss", "best_epoch", "finished", "curves")


def restored(path: Path, fresh: Callable[[int], FitState[Module]]) -> FitState[Module]:
    """The state that a checkpoint holds, or `fresh(1)` if there is none.

    `fresh` makes a state to fill, for the round it is in. Raises `OutputError` on a damaged file.
    """
    if not path.exists():
        return fresh(1)
    try:
        checkpoint = torch.load(path, weights_only=True)
        return unpack(checkpoint, fresh(checkpoint["round"]))
    except Exception as error:  # torch raises many kinds on a damaged file
        raise OutputError(
            f"the checkpoint '{path}' can't be read ({type(error).__name__}): delete it to train "
            "again on the same flights"
        ) from error


def run_round(state: FitState, epochs: int, path: Path, run_epoch: Callable[[], None]) -> None:
    """Run epochs to the end of the round, with a checkpoint after each."""
    bar = tqdm(total=epochs, initial=state.epoch, desc=f"round {state.round}",
               unit="epoch", disable=None)  # fmt: skip
    with bar:
        while not state.finished:
            run_epoch()
            buffer = io.BytesIO()
            torch.save(pack(state), buffer)
            write_bytes(path, buffer.getvalue())
            bar.set_postfix_str(f"held-out loss {state.best_loss:.4f}", refresh=False)
            bar.update()
