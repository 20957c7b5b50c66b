"""A spacecraft's files, to carry them elsewhere: the MJCF, what it includes, and its assets."""

import os
import shutil
from pathlib import Path

import mujoco

from simsat.control.ground.errors import ModelError
from simsat.mjcf.engine import COMPILED, compiled, parsed
from simsat.mjcf.identity import model_identity
from simsat.mjcf.motors.failed import with_failed_locked
from simsat.mjcf.reader import Model


def copy_model(model: Model, path: Path, folder: Path) -> Path:
    """Copy a spacecraft into a folder, which is made; returns the file to read it from.

    Files keep their places relative to each other. A model that has no file is kept compiled, and
    so is one whose copy would not compile to the same. Raises `OSError`.
    """
    if path.is_file() and path.suffix != COMPILED:
        copied = _copy_files(path, folder)
        if copied is not None and _same(copied, model):
            return copied
        shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    kept = folder / f"{model.spacecraft.name}{COMPILED}"
    mujoco.mj_saveModel(model.mj, str(kept), None)
    return kept


def model_files(path: Path) -> tuple[Path, ...]:
    """All files that a spacecraft is compiled from, absolute: includes and assets with it."""
    parts = (Path(part).resolve() for part in mujoco.mju_getXMLDependencies(str(path)))
    return tuple(part for part in parts if part.is_file())


def _copy_files(path: Path, folder: Path) -> Path | None:
    try:
        files = model_files(path)
    except (OSError, ValueError):
        return None
    root = Path(os.path.commonpath([file.parent for file in files]))
    for file in files:
        copied = folder / file.relative_to(root)
        copied.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copied)
    return folder / path.resolve().relative_to(root)


def _same(path: Path, model: Model) -> bool:
    try:
        source, _ = parsed(path)
        assert isinstance(source, mujoco.MjSpec)  # it is no compiled file
        return model_identity(compiled(with_failed_locked(source))[0]) == model.identity
    except ModelError:
        return False
