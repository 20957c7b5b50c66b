"""What the commands that train share: claim the folder, train, and say how an interrupt goes on."""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from simsat.campaign.lock import locked
from simsat.mjcf import read_model
from simsat.mjcf.shipped import find_model

from .files import claim_folder
from .progress import INTERRUPTED

Training = TypeVar("Training")
"""Settings with all that decides the result, `model` among them."""


def train_resumably(
    training: Training,
    out: Path,
    workers: int,
    train: Callable[[Training, Path, int], None],
    done: str,
) -> int:
    """Train into a folder, or go on with what it holds; the exit code. `done` is printed at the
    end.

    Raises `OutputError` if the folder holds something else or another process trains in it.
    """
    settings: Any = training
    settings = replace(settings, model=find_model(settings.model).resolve())
    read_model(settings.model)  # a bad model is refused before a folder is claimed for it
    claim_folder(out, settings)
    try:
        with locked(out):
            train(settings, out, workers)
    except KeyboardInterrupt:
        print(f"interrupted; the same command goes on where '{out}' stands", file=sys.stderr)
        return INTERRUPTED
    print(f"\n{done}")
    return 0
