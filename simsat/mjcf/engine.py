"""MuJoCo's own messages: its errors become a `ModelError`, its warnings are handed over.

Left alone MuJoCo prints its warnings and appends them to a MUJOCO_LOG.TXT in the working directory,
in flight too. Importing this module ends both: the plant asks for finite numbers itself.
"""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco

from simsat.control.ground.errors import ModelError

COMPILED = ".mjb"  # MuJoCo's own format: for models that were built in Python


def _hush() -> None:
    config = mujoco.MjLogConfig.get()
    config.logto_console = config.logto_file = False
    config.set()


_hush()


def parsed(path: Path) -> tuple[mujoco.MjSpec | mujoco.MjModel, tuple[str, ...]]:
    """A file as it is written, includes and defaults resolved, and MuJoCo's warnings about it.

    A file that was kept compiled (.mjb) is just loaded. Raises `ModelError` where MuJoCo can't read
    it; the message names element and line.
    """
    source: mujoco.MjSpec | mujoco.MjModel
    with _heard() as said:
        if path.suffix == COMPILED:
            source = mujoco.MjModel.from_binary_path(str(path))
        else:
            source = mujoco.MjSpec.from_file(str(path))
    return source, tuple(dict.fromkeys(said))


def compiled(spec: mujoco.MjSpec) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """The model that MuJoCo makes of it, and its warnings. Raises `ModelError` where it can't.

    How far a muscle can pull is left out: no wheel asks, and MuJoCo finds it by flying the model
    for as long as it takes, which is for ever where a number is nan.
    """
    lengths = spec.compiler.LRopt
    before = lengths.mode
    lengths.mode = mujoco.mjtLRMode.mjLRMODE_NONE
    try:
        with _heard() as said:
            m = spec.compile()
    finally:
        lengths.mode = before
    return m, tuple(dict.fromkeys(said))


@contextmanager
def translated() -> Iterator[None]:
    """What makes MuJoCo give up inside, out of its memory say, is a `ModelError`."""
    try:
        yield
    except mujoco.FatalError as error:
        raise ModelError(f"MuJoCo gives up on it: {_one_line(error)}") from error


@contextmanager
def _heard() -> Iterator[list[str]]:
    """MuJoCo's warnings, both those that it prints and those of its Python binding."""
    heard: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: heard.append(_one_line(text)))
    try:
        with translated(), warnings.catch_warnings(record=True) as raised:
            warnings.simplefilter("always")
            yield heard
        heard += [_one_line(warning.message) for warning in raised]
    except (ValueError, RuntimeError, MemoryError) as error:
        raise ModelError(_one_line(error) or "MuJoCo can't read it and gives no reason") from error
    finally:
        mujoco.set_mju_user_warning(before)


def _one_line(message: object) -> str:
    return " ".join(str(message).split())
