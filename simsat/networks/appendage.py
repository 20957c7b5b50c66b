"""Files of appendage networks: what they belong to, and which are refused.

A file holds all arrays of an `AppendageNetwork` in float64; a layer that is not there has no rows.
Its metadata name the spacecraft (`fingerprint`) and the control period. They
name no belief: the inertia that c was learned for is in the file.
"""

import os.path
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from simsat.control.ground.errors import ForeignNetworkError, NetworkError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.appendage import MOMENTA, AppendageNetwork
from simsat.mjcf.shipped import find_model
from simsat.networks.files import NetworkFile, read_network_file, write_network_file

FILE = "appendage.safetensors"
REMEDY = "train one for this model (python -m learning.train_appendage)"

SCALES = ("input_scale", "spin_scale", "output_scale")
WEIGHTS = ("W", "U", "V", "E", "G", "B")


def shipped_appendage(model: Path) -> Path | None:
    """The file that comes with a model, or None if none does."""
    path = find_model(model).parent / "network" / FILE
    return path if os.path.isfile(path) else None


def find_appendage(spec: str, model: Path) -> Path | None:
    """The file that `--learned.network` means, or None for none.

    "auto" is the one beside the model, if there is one; else a file, or the folder of a training.
    Raises `NetworkError` if it isn't there.
    """
    if spec == "none":
        return None
    if spec == "auto":
        return shipped_appendage(model)
    path = Path(spec) / FILE if os.path.isdir(spec) else Path(spec)
    if not os.path.isfile(path):
        raise NetworkError(
            f"no network file at '{path}': --learned.network takes auto, none, a file or a folder "
            f"that 'python -m learning.train_appendage --model {model} --out DIR' wrote"
        )
    return path


def choose_appendage(
    spec: str, model: Path, craft: Spacecraft, period: float
) -> AppendageNetwork | None:
    """The network that `--learned.network` means, read for a spacecraft and control period (s).

    With "auto" one that belongs elsewhere is left alone: the model was edited. Raises
    `NetworkError`.
    """
    path = find_appendage(spec, model)
    if path is None:
        return None
    try:
        return read_appendage(path, craft, period)
    except ForeignNetworkError:
        if spec == "auto":
            return None
        raise


def write_appendage(
    path: Path,
    network: AppendageNetwork,
    craft: Spacecraft,
    about: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Write a network with the spacecraft it belongs to, and what else is known about it."""
    names = ("J", *SCALES, *WEIGHTS)
    metadata = {
        "spacecraft": craft.name,
        "fingerprint": craft.fingerprint,
        "period_s": repr(network.period),
        **about,
    }
    write_network_file(path, {name: getattr(network, name) for name in names}, metadata)


def read_appendage(path: Path, craft: Spacecraft, period: float) -> AppendageNetwork:
    """A network from its file, if it belongs to this spacecraft and control period (s).

    Raises `NetworkError`.
    """
    file = read_network_file(path, REMEDY)
    network = _network(file)
    if network.wheels != craft.wheels:
        raise file.foreign(f"is for {network.wheels} wheels, but '{craft.name}' has {craft.wheels}")
    file.require_spacecraft(craft)
    if network.period != period:
        raise file.foreign(f"steps by {network.period:g} s, but the control period is {period:g} s")
    return network


def _network(file: NetworkFile) -> AppendageNetwork:
    tensors = file.tensors
    file.require_names({"J", *SCALES, *WEIGHTS}, {"period_s"})
    file.require_numbers(SCALES)
    inputs = tensors["input_scale"].size
    wheels, rest = divmod(inputs - MOMENTA, 3)
    width, gates = (tensors[name].shape[0] if tensors[name].ndim else 0 for name in "UE")
    wanted = {
        "J": (3, 3),
        "input_scale": (inputs,),
        "spin_scale": (wheels,),
        "output_scale": (MOMENTA,),
        "W": (MOMENTA, inputs),
        "U": (width, inputs),
        "V": (MOMENTA, width),
        "E": (gates, inputs),
        "G": (gates, wheels),
        "B": (MOMENTA, gates),
    }
    if rest or wheels < 1 or any(tensors[name].shape != wanted[name] for name in wanted):
        raise file.refusal(f"has parts that don't fit each other ({file.shapes()})")
    period = file.positive("period_s", "a control period", "s")
    return AppendageNetwork(**tensors, period=period)
