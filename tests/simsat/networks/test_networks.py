import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from simsat.control.correction.network import Network
from simsat.control.ground.errors import NetworkError
from simsat.control.ground.spacecraft import Spacecraft, nominal
from simsat.flight.mission import prepare
from simsat.mjcf import Model
from simsat.mjcf.shipped import MODELS
from simsat.networks.correction import find_network, origin, read_network, write_network
from simsat.settings import FlightSettings


def random_network(inputs: int = 16, outputs: int = 2) -> Network:
    random = np.random.default_rng(3)
    sizes = (inputs, 8, outputs)
    return Network(
        random.standard_normal(inputs),
        random.uniform(0.5, 2.0, inputs),
        tuple(random.standard_normal((b, a)) for a, b in pairwise(sizes)),
        tuple(random.standard_normal(b) for b in sizes[1:]),
        0.015,
    )


@pytest.fixture
def craft(two_wheel: Model) -> Spacecraft:
    return two_wheel.spacecraft


@pytest.fixture
def file(tmp_path: Path, craft: Spacecraft) -> Path:
    path = tmp_path / "net.safetensors"
    write_network(path, random_network(), origin(craft, nominal(craft), friction=False))
    return path


def read(file: Path, craft: Spacecraft, **kwargs: Any) -> Network:
    return read_network(file, craft, nominal(craft), friction=False, **kwargs)


def rewrite(file: Path, craft: Spacecraft, **changes: Any) -> None:
    """Replace tensors of a file, its metadata kept."""
    metadata = {"bound_Nm": "0.015", **origin(craft, nominal(craft), friction=False)}
    save_file({**load_file(file), **changes}, file, metadata)


def test_a_file_gives_back_the_network(file: Path, craft: Spacecraft) -> None:
    x = np.random.default_rng(0).standard_normal((5, 16))
    assert np.array_equal(read(file, craft).estimate(x), random_network().estimate(x))
    assert np.abs(read(file, craft).estimate(100 * x)).max() <= 0.015


def test_another_spacecrafts_network_is_refused_unless_asked_for(
    file: Path, craft: Spacecraft
) -> None:
    other = replace(craft, name="other", fingerprint="0123")
    message = (
        r"trained for the spacecraft 'two_wheel' \(\w+\), not for 'other' \(0123\): train one for "
        r"this model \(python -m learning.train\) or fly --controller nmpc"
    )
    with pytest.raises(NetworkError, match=message):
        read(file, other)
    assert read(file, other, foreign=True).outputs == 2


def test_a_network_for_another_belief_is_refused(file: Path, craft: Spacecraft) -> None:
    for believed, friction in ((nominal(craft, mismatch=2.0), False), (nominal(craft), True)):
        with pytest.raises(NetworkError, match="another nominal model of 'two_wheel'"):
            read_network(file, craft, believed, friction)


def test_a_network_for_more_wheels_is_refused(file: Path, craft: Spacecraft) -> None:
    write_network(file, random_network(18, 3), origin(craft, nominal(craft), friction=False))
    message = r"maps 18 inputs to 3 torques, but 'two_wheel' with 2 wheels needs 16 to 2"
    with pytest.raises(NetworkError, match=message):
        read(file, craft, foreign=True)


def test_a_truncated_file_is_refused(file: Path, craft: Spacecraft) -> None:
    whole = file.read_bytes()
    for length in (0, 5, 200, len(whole) - 8):
        file.write_bytes(whole[:length])
        with pytest.raises(NetworkError, match=r"not a readable network file .*: copy it again"):
            read(file, craft)


def test_a_file_of_something_else_is_refused(file: Path, craft: Spacecraft) -> None:
    save_file({"embedding": np.zeros(3)}, file)
    with pytest.raises(NetworkError, match=r"no network of this project \(it holds embedding\)"):
        read(file, craft)


def test_numbers_that_are_not_finite_are_refused(file: Path, craft: Spacecraft) -> None:
    bias = load_file(file)["bias_1"]
    bias[0] = np.nan
    rewrite(file, craft, bias_1=bias)
    with pytest.raises(NetworkError, match="not finite or scales not above zero in bias_1: train"):
        read(file, craft)


def test_a_scale_of_zero_is_refused(file: Path, craft: Spacecraft) -> None:
    rewrite(file, craft, scale=np.zeros(16))
    with pytest.raises(NetworkError, match="scales not above zero in scale: train"):
        read(file, craft)


def repacked(file: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """The file with its header changed, the numbers left as they are."""
    content = file.read_bytes()
    end = 8 + int.from_bytes(content[:8], "little")
    header = json.loads(content[8:end])
    change(header)
    text = json.dumps(header).encode()
    file.write_bytes(len(text).to_bytes(8, "little") + text + content[end:])


@pytest.mark.parametrize(
    "text", ["nan", "inf", "-inf", "-0.015", "0", "1e999", "a lot", "", "None"]
)
def test_a_bound_that_is_none_is_refused(file: Path, craft: Spacecraft, text: str) -> None:
    """A bound of nan would command nan."""
    repacked(file, lambda header: header["__metadata__"].update(bound_Nm=text))
    message = rf"states an output bound of '{re.escape(text)}' Nm: train one for this model"
    with pytest.raises(NetworkError, match=message):
        read(file, craft)


def test_a_file_that_names_no_spacecraft_is_refused(file: Path, craft: Spacecraft) -> None:
    repacked(file, lambda header: header["__metadata__"].pop("fingerprint"))
    with pytest.raises(
        NetworkError, match=r"trained for the spacecraft 'two_wheel' \(\?\), not for"
    ):
        read(file, craft)


@pytest.mark.parametrize(("kind", "named"), [("I64", "int64"), ("U64", "uint64")])
def test_whole_numbers_are_refused(file: Path, craft: Spacecraft, kind: str, named: str) -> None:
    repacked(file, lambda header: header["mean"].update(dtype=kind))
    message = rf"holds no floating-point numbers in mean \({named}\): train one"
    with pytest.raises(NetworkError, match=message):
        read(file, craft)


def test_a_header_larger_than_the_file_is_refused(file: Path, craft: Spacecraft) -> None:
    whole = file.read_bytes()
    for size in (len(whole), 2**40, 2**64 - 1):
        file.write_bytes(size.to_bytes(8, "little") + whole[8:])
        with pytest.raises(NetworkError, match=r"not a readable network file .*: copy it again"):
            read(file, craft)


def test_layers_that_do_not_fit_are_refused(file: Path, craft: Spacecraft) -> None:
    rewrite(file, craft, weight_1=np.zeros((2, 9)))
    with pytest.raises(NetworkError, match=r"layers in .* don't fit each other .*\(2, 9\)"):
        read(file, craft)


def test_a_missing_file_says_how_to_train_one(tmp_path: Path) -> None:
    message = "no network file at .*none.safetensors.: train one with 'python -m learning.train"
    with pytest.raises(NetworkError, match=message):
        find_network(str(tmp_path / "none.safetensors"), Path("two_wheel"))
    settings = FlightSettings(model=Path("pyramid"), controller="nmpc-pinn")
    with pytest.raises(NetworkError, match=r"no network file at .*pyramid/network/pinn"):
        prepare(settings)


def test_a_name_a_file_and_a_folder_name_a_network(file: Path, tmp_path: Path) -> None:
    assert find_network(str(file), Path("two_wheel")) == file
    trained = file.rename(tmp_path / "pinn.safetensors")
    assert find_network(str(tmp_path), Path("two_wheel")) == trained
    shipped = MODELS / "two_wheel" / "network" / "linear.safetensors"
    assert find_network("linear", Path("two_wheel")) == shipped


def test_flying_a_network_needs_no_torch() -> None:
    code = (
        "import sys\n"
        "from simsat.flight.mission import prepare\n"
        "from simsat.settings import FlightSettings\n"
        "prepare(FlightSettings(controller='nmpc-pinn', duration_s=1.0)).fly()\n"
        "sys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
