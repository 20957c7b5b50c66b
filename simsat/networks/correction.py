"""Network files: where they are, what they belong to, and which are refused.

A file is safetensors: `mean`, `scale`, and per layer `weight_0`, `bias_0`, ... in float64. Its
metadata name the spacecraft (`fingerprint`), the belief it corrects (`belief`), the sample rate and
the bound of the output.
"""

import hashlib
import os.path
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from simsat.control.correction.features import feature_count
from simsat.control.correction.network import Network
from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import NetworkError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.mjcf.shipped import find_model
from simsat.networks.files import NetworkFile, read_network_file, write_network_file

NAMES = ("pinn", "linear")
"""Networks that training writes, and that come with some models."""

REMEDY = "train one for this model (python -m learning.train) or fly --controller nmpc"


def find_network(network: str, model: Path) -> Path:
    """The file that `--network` means: a name (beside the model), a file, or a training folder.

    Raises `NetworkError` if there is none.
    """
    path = Path(network)
    if os.path.isdir(path):
        path = path / "pinn.safetensors"
    elif network in NAMES:
        path = find_model(model).parent / "network" / f"{network}.safetensors"
    if not os.path.isfile(path):
        raise NetworkError(
            f"no network file at '{path}': train one with 'python -m learning.train --model "
            f"{model} --out DIR' and fly it with --network DIR, or fly --controller nmpc"
        )
    return path


def belief_fingerprint(believed: Spacecraft, friction: bool) -> str:
    """Hash of what a network corrects: the believed inertia, and whether friction is believed."""
    text = f"{np.array2string(believed.J, precision=9)};{friction}"
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def write_network(path: Path, network: Network, origin: Mapping[str, str]) -> None:
    """Write a network with its origin (see `origin`) by way of a temporary file."""
    tensors = {"mean": network.mean, "scale": network.scale}
    for layer, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
        tensors |= {f"weight_{layer}": weight, f"bias_{layer}": bias}
    metadata = {"bound_Nm": "none" if network.bound is None else repr(network.bound), **origin}
    write_network_file(path, tensors, metadata)


def origin(craft: Spacecraft, believed: Spacecraft, friction: bool) -> dict[str, str]:
    """Metadata that say which spacecraft and which belief a network belongs to."""
    return {
        "spacecraft": craft.name,
        "fingerprint": craft.fingerprint,
        "belief": belief_fingerprint(believed, friction),
    }


def read_network(
    path: Path, craft: Spacecraft, believed: Spacecraft, friction: bool, foreign: bool = False
) -> Network:
    """A network from its file, if it belongs to this spacecraft and belief.

    `foreign` lets another spacecraft's pass, if the number of wheels fits. Raises `NetworkError`.
    """
    file = read_network_file(path, REMEDY)
    network = _network(file)
    shape, wanted = (network.inputs, network.outputs), (feature_count(craft.wheels), craft.wheels)
    if shape != wanted:
        raise file.refusal(
            f"maps {shape[0]} inputs to {shape[1]} torques, but '{craft.name}' with "
            f"{craft.wheels} wheels needs {wanted[0]} to {wanted[1]}"
        )
    if foreign:
        return network
    file.require_spacecraft(craft)
    if file.metadata.get("belief") != belief_fingerprint(believed, friction):
        raise file.refusal(
            f"was trained to correct another nominal model of '{craft.name}' (--nominal.*"
            " or --nmpc.friction differ)"
        )
    return network


def _network(file: NetworkFile) -> Network:
    tensors = file.tensors
    layers = max(1, sum(name.startswith("weight_") for name in tensors))
    parts = {f"{kind}_{i}" for kind in ("weight", "bias") for i in range(layers)}
    file.require_names({"mean", "scale"} | parts, {"bound_Nm"})
    file.require_numbers(("scale",))
    weights = tuple(tensors[f"weight_{i}"] for i in range(layers))
    biases = tuple(tensors[f"bias_{i}"] for i in range(layers))
    if not _chained(tensors["mean"], tensors["scale"], weights, biases):
        raise NetworkError(
            f"the layers in '{file.path}' don't fit each other ({file.shapes()}): {REMEDY}"
        )
    unbounded = file.metadata["bound_Nm"] == "none"
    bound = None if unbounded else file.positive("bound_Nm", "an output bound", "Nm")
    return Network(tensors["mean"], tensors["scale"], weights, biases, bound)


def _chained(
    mean: Array, scale: Array, weights: tuple[Array, ...], biases: tuple[Array, ...]
) -> bool:
    if any(weight.ndim != 2 for weight in weights):
        return False
    width: tuple[int, ...] = mean.shape
    for weight, bias in zip(weights, biases, strict=True):
        if (weight.shape[1],) != width or bias.shape != (weight.shape[0],):
            return False
        width = bias.shape
    return scale.shape == mean.shape
