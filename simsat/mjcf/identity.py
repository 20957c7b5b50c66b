"""What a compiled model is: one hash of everything that MuJoCo flies with.

The file that names the model says too little: an included file or a mesh may change under it. All
of them end in the compiled model, whose numbers and names are hashed here.
"""

import hashlib
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

PLACES = ("paths", "npaths", "nbuffer")  # where assets lie, and what depends on it
PATH_ADDRESS = "_pathadr"
DRAWN_ONLY = ("vis",)  # MuJoCo's own pictures


def model_identity(m: mujoco.MjModel) -> str:
    """SHA-256 of the compiled model, in hexadecimal: the same wherever its files lie."""
    digest = hashlib.sha256()
    for name, content in _fields(m):
        digest.update(f"{name} {len(content)} ".encode() + content)
    return digest.hexdigest()


def _fields(part: Any, prefix: str = "") -> Iterator[tuple[str, bytes]]:
    """Every number and name in it, in the order of the fields' names."""
    for name in dir(part):
        if name.startswith("_") or name in (*PLACES, *DRAWN_ONLY) or name.endswith(PATH_ADDRESS):
            continue
        value = getattr(part, name)
        if isinstance(value, np.ndarray):
            yield f"{prefix}{name} {value.dtype.str}{value.shape}", value.tobytes()
        elif isinstance(value, (int, float, bytes)):
            yield prefix + name, repr(value).encode()
        elif not callable(value):
            yield from _fields(value, f"{prefix}{name}.")
