"""Files of appendage networks: what was written is read, and what doesn't belong is refused."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from simsat.control.ground.errors import NetworkError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.control.model.appendage import AppendageNetwork
from simsat.mjcf import Model
from simsat.networks.appendage import (
    SCALES,
    WEIGHTS,
    read_appendage,
    shipped_appendage,
    write_appendage,
)
from tests.appendage_cases import PERIOD, random_network

REMEDY = r": train one for this model \(python -m learning.train_appendage\)"


@pytest.fixture
def craft(two_wheel: Model) -> Spacecraft:
    return two_wheel.spacecraft


@pytest.fixture
def file(tmp_path: Path, craft: Spacecraft) -> Path:
    path = tmp_path / "appendage.safetensors"
    write_appendage(path, random_network(), craft)
    return path


def rewrite(file: Path, craft: Spacecraft, period: str = "0.5", **changes: Any) -> None:
    """Replace tensors of a file; None takes one out."""
    tensors = {**load_file(file), **changes}
    metadata = {"spacecraft": "two_wheel", "fingerprint": craft.fingerprint, "period_s": period}
    save_file({k: v for k, v in tensors.items() if v is not None}, file, metadata)


def same(a: AppendageNetwork, b: AppendageNetwork) -> bool:
    names = ("J", *SCALES, *WEIGHTS)
    return a.period == b.period and all(
        np.array_equal(getattr(a, name), getattr(b, name)) for name in names
    )


@pytest.mark.parametrize(("width", "gates"), [(5, 4), (5, 0), (0, 4), (0, 0)])
def test_a_file_gives_back_the_network(
    file: Path, craft: Spacecraft, width: int, gates: int
) -> None:
    network = random_network(width, gates=gates)
    write_appendage(file, network, craft)
    again = read_appendage(file, craft, PERIOD)
    assert same(again, network)
    assert (again.width, again.gates) == (width, gates)
    assert not list(file.parent.glob("*.part"))


def test_equal_networks_make_equal_files(file: Path, craft: Spacecraft) -> None:
    """In whatever order the hashes of a process put the names."""
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        "from simsat.networks.appendage import write_appendage\n"
        "from simsat.mjcf import read_model\n"
        "from simsat.mjcf.shipped import find_model\n"
        "from tests.appendage_cases import random_network\n"
        "craft = read_model(find_model(Path('two_wheel'))).spacecraft\n"
        "write_appendage(Path(sys.argv[1]), random_network(), craft)\n"
    )
    for seed in ("1", "2"):
        again = file.with_stem(f"again_{seed}")
        subprocess.run(
            [sys.executable, "-c", code, str(again)],
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        )
        assert again.read_bytes() == file.read_bytes()


def test_another_spacecrafts_network_is_refused(file: Path, craft: Spacecraft) -> None:
    other = replace(craft, name="other", fingerprint="0123")
    message = r"trained for the spacecraft 'two_wheel' \(\w+\), not for 'other' \(0123\)" + REMEDY
    with pytest.raises(NetworkError, match=message):
        read_appendage(file, other, PERIOD)


def test_a_network_for_more_wheels_is_refused(file: Path, craft: Spacecraft) -> None:
    write_appendage(file, random_network(wheels=3), craft)
    message = "is for 3 wheels, but 'two_wheel' has 2" + REMEDY
    with pytest.raises(NetworkError, match=message):
        read_appendage(file, craft, PERIOD)


def test_another_control_period_is_refused(file: Path, craft: Spacecraft) -> None:
    message = "steps by 0.5 s, but the control period is 0.25 s" + REMEDY
    with pytest.raises(NetworkError, match=message):
        read_appendage(file, craft, 0.25)
    for text in ("often", "-1", "nan"):
        rewrite(file, craft, text)
        with pytest.raises(NetworkError, match=f"states a control period of '{text}' s{REMEDY}"):
            read_appendage(file, craft, PERIOD)


def test_a_truncated_file_is_refused(file: Path, craft: Spacecraft) -> None:
    whole = file.read_bytes()
    for length in (0, 5, 200, len(whole) - 8):
        file.write_bytes(whole[:length])
        with pytest.raises(NetworkError, match=r"not a readable network file .*: copy it again"):
            read_appendage(file, craft, PERIOD)


def test_a_file_of_something_else_is_refused(file: Path, craft: Spacecraft) -> None:
    rewrite(file, craft, V=None)
    held = r"is no network of this project \(it holds B, E, G, J, U, W, input_scale, output_scale, "
    with pytest.raises(NetworkError, match=held + r"spin_scale\)" + REMEDY):
        read_appendage(file, craft, PERIOD)
    save_file({"embedding": np.zeros(3)}, file)
    with pytest.raises(NetworkError, match=r"no network of this project \(it holds embedding\)"):
        read_appendage(file, craft, PERIOD)


def test_numbers_that_are_not_finite_are_refused(file: Path, craft: Spacecraft) -> None:
    rewrite(file, craft, W=np.full((6, 12), np.inf))
    with pytest.raises(NetworkError, match="not finite or scales not above zero in W" + REMEDY):
        read_appendage(file, craft, PERIOD)
    write_appendage(file, random_network(), craft)
    rewrite(file, craft, output_scale=np.zeros(6))
    with pytest.raises(NetworkError, match="scales not above zero in output_scale" + REMEDY):
        read_appendage(file, craft, PERIOD)


@pytest.mark.parametrize(
    "changes",
    [
        {"V": np.ones((6, 4))},
        {"W": np.ones((6, 13))},
        {"J": np.eye(2)},
        {"output_scale": np.ones(5)},
        {"input_scale": np.ones(11), "W": np.ones((6, 11)), "U": np.ones((5, 11))},
        {"U": np.array(1.0)},
        {"E": np.ones((3, 12))},
        {"G": np.ones((4, 3))},
        {"B": np.ones((6, 5))},
        {"E": np.array(1.0)},
        {"spin_scale": np.ones(3)},
    ],
)
def test_parts_that_do_not_fit_are_refused(
    file: Path, craft: Spacecraft, changes: dict[str, Any]
) -> None:
    rewrite(file, craft, **changes)
    with pytest.raises(NetworkError, match=r"has parts that don't fit each other \(B \("):
        read_appendage(file, craft, PERIOD)


def test_a_model_has_a_network_or_none() -> None:
    path = shipped_appendage(Path("flexible_panels"))
    assert path is not None
    assert path.is_file()
    assert shipped_appendage(Path("two_wheel")) is None
