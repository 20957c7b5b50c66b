"""The names of shapes: what mypy tells apart, and what a checked call refuses."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from jaxtyping import TypeCheckError

from simsat.control.ground.arrays import Array
from simsat.control.ground.attitude import error_angle, rotation_vector
from simsat.control.ground.spacecraft import Spacecraft
from tests.places import ROOT

NAMES = ("Vector3", "Quaternion", "Matrix3", "WheelVector", "WheelAxes")

UNSEEN = {(name, name) for name in NAMES} | {("WheelAxes", "Matrix3")}
"""(given, wanted) that mypy lets pass; the last has two axes as a matrix has."""


def test_mypy_tells_the_names_apart(tmp_path: Path) -> None:
    pairs = [(given, wanted) for given in NAMES for wanted in NAMES]
    lines = [f"from simsat.control.ground.arrays import {', '.join(NAMES)}"]
    lines += [
        f"def f{i}(x: {given}) -> {wanted}: return x" for i, (given, wanted) in enumerate(pairs)
    ]
    snippet = tmp_path / "snippet.py"
    snippet.write_text("\n".join(lines))
    said = subprocess.run(
        [sys.executable, "-m", "mypy", "--no-error-summary", snippet],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    refused = {int(line.split(":")[1]) - 2 for line in said.stdout.splitlines()}
    assert {pair for i, pair in enumerate(pairs) if i not in refused} == UNSEEN, said


@pytest.mark.parametrize("wrong", [np.zeros(3), np.zeros((4, 3)), np.array([1, 0, 0, 0])])
def test_a_wrong_shape_or_type_is_refused(wrong: Array) -> None:
    with pytest.raises(
        TypeCheckError, match=r"parameter 'q'(.|\n)*Float64\[ndarray, '\*#batch 4'\]"
    ):
        rotation_vector(wrong)


def test_batches_of_a_call_fit_each_other() -> None:
    q = np.tile([1.0, 0.0, 0.0, 0.0], (5, 1))
    assert error_angle(q, q[0]).shape == error_angle(q, q).shape == (5,)
    with pytest.raises(TypeCheckError, match="parameter 'q_target'"):
        error_angle(q, q[:4])


def test_the_fields_of_a_dataclass_have_one_number_of_wheels() -> None:
    two, three = np.ones(2), np.ones(3)
    with pytest.raises(TypeCheckError, match="parameter 'viscous'"):
        Spacecraft(
            "odd", 1.0, np.eye(3), ("a", "b"), np.eye(3)[:, :2], two, two, two, two, three, two
        )


def test_nothing_is_checked_or_imported_outside_the_tests() -> None:
    script = (
        "import sys, numpy as np\n"
        "from simsat.control.ground.attitude import conjugate, normalized\n"
        "conjugate([1.0, 0.0, 0.0, 0.0]), normalized(np.ones(3))\n"
        "assert not {'jaxtyping', 'beartype'} & sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True)
