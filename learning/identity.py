"""What a training depends on besides its settings; its folder and its networks state it."""

import json
from pathlib import Path
from typing import Any

from simsat.identity.code import TRAINING_PACKAGES, computing
from simsat.mjcf import read_model
from simsat.mjcf.shipped import find_model


def training_identity(model: Path) -> dict[str, Any]:
    """The compiled model, the code with that of training, its packages, Python and platform.

    Raises `ModelError`.
    """
    identity = read_model(find_model(model)).identity
    return {"model": identity, **computing(TRAINING_PACKAGES, training=True)}


def trained_with(model: Path) -> dict[str, str]:
    """The same as metadata of a network file."""
    return {"trained_with": json.dumps(training_identity(model), sort_keys=True)}
