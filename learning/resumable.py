"""What the commands that train share: claim the folder, train, and say how an interrupt goes on."""

import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from simsat.mjcf import read_model
from simsat.settings import find_model

from .files import claim_folder
from .progress import INTERRUPTED


class Asked(Protocol):
    """A command line: settings of a training, and where and how it runs."""

    @property
    def out(self) -> Path:
        """The folder to write."""
        ...

    @property
    def workers(self) -> int:
        """Processes to fly in."""
        ...


Settings = TypeVar("Settings")
"""Dataclass with all that decides the result; the command line's fields begin with its own."""


def train_resumably(
    asked: Asked, kind: type[Settings], train: Callable[[Settings, Path, int], None], done: str
) -> int:
    """Train into the folder asked for, or go on with what it holds; the exit code.

    `done` is printed at the end.
    """
    made: Any = kind
    settings = made(**{one.name: getattr(asked, one.name) for one in fields(made)})
    settings = replace(settings, model=find_model(settings.model).resolve())
    read_model(settings.model)  # a bad model is refused before a folder is claimed for it
    claim_folder(asked.out, settings)
    try:
        train(settings, asked.out, asked.workers)
    except KeyboardInterrupt:
        print(f"interrupted; the same command goes on where '{asked.out}' stands", file=sys.stderr)
        return INTERRUPTED
    print(f"\n{done}")
    return 0
