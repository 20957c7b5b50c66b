"""Every example is run as a user would: copied into an empty folder and started there."""

import ast
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from rerun.chunk import RrdReader

from tests.docs_cases import EXAMPLES, python, shows

TRAINED = ("learn_a_slew",)  # has a test of its own with a smaller budget
NAMES = sorted(path.stem for path in EXAMPLES.glob("*.py") if path.stem not in TRAINED)


def copied(name: str, folder: Path) -> Path:
    return Path(shutil.copy(EXAMPLES / f"{name}.py", folder))


@pytest.mark.parametrize("name", NAMES)
def test_an_example_prints_what_its_docstring_shows_and_draws_a_picture(
    name: str, tmp_path: Path
) -> None:
    script = copied(name, tmp_path)
    docstring = ast.get_docstring(ast.parse(script.read_text()), clean=False) or ""
    shown = re.findall(r"^ {4,}(\S.*)$", docstring, re.MULTILINE)
    assert shown, f"{name} shows nothing that it prints"
    printed = python(tmp_path, script.name)
    for line in shown:
        assert shows(line, printed), f"{name} shows\n{line}\nbut prints\n{printed}"
    picture = imread(tmp_path / f"{name}.png")
    assert min(picture.shape[:2]) >= 400
    assert np.std(picture) > 0.05, "an empty page"


def test_a_third_of_the_learning_already_turns_the_spacecraft(tmp_path: Path) -> None:
    copied("learn_a_slew", tmp_path)
    printed = python(tmp_path, "-c", "import learn_a_slew; learn_a_slew.main(generations=8)")
    untrained, trained = (
        float(re.findall(rf"^{name} +([\d.]+) deg off", printed, re.MULTILINE)[0])
        for name in ("untrained", "trained")
    )
    assert untrained > 30.0, "a start below the range that the environment draws from"
    assert trained < untrained / 3
    assert (tmp_path / "learn_a_slew.png").exists()


def test_an_own_torque_is_in_the_recording(tmp_path: Path) -> None:
    copied("own_torque_and_metric", tmp_path)
    python(
        tmp_path,
        *("-m", "simsat.run", "--torque", "own_torque_and_metric:leak", "--duration-s", "25"),
        *("--model", "three_wheel", "--out", "flown"),
    )
    rows = []
    for chunk in RrdReader(tmp_path / "flown" / "recording.rrd").stream():
        batch = chunk.to_record_batch()
        if "leak" in str(chunk.entity_path) and "Scalars:scalars" in batch.schema.names:
            rows += batch["Scalars:scalars"].to_pylist()
    assert rows[0] == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(rows[-1], [10.0, 20.0, 30.0], rtol=1e-6)  # in uNm


def test_own_controllers_fly_from_the_command_line(tmp_path: Path) -> None:
    copied("own_controller", tmp_path)
    printed = python(
        tmp_path,
        *("-m", "simsat.run", "--controller", "own_controller:PD", "--model", "three_wheel"),
        *("--out", "flown", "--no-recording"),
    )
    assert re.search(r"converged +yes", printed)
    assert (tmp_path / "flown" / "summary.png").exists()


def test_own_controllers_fly_from_a_line_of_python(tmp_path: Path) -> None:
    copied("own_controller", tmp_path)
    line = (
        "import simsat, own_controller as own; print(simsat.fly('three_wheel', controller=own.PD))"
    )
    assert "settled at" in python(tmp_path, "-c", line)


def test_a_controller_typed_into_python_c_flies(tmp_path: Path) -> None:
    line = """
import numpy as np, simsat
def at_rest(brief):
    return lambda now: np.zeros(brief.truth.wheels)
print(simsat.fly('three_wheel', controller=at_rest, duration_s=10))
"""
    assert "at_rest: 125 deg" in python(tmp_path, "-c", line)


def test_what_is_shown_and_not_printed_is_found_out() -> None:
    printed = "nmpc  settled at t = 23.70 s, 0.0755 deg at the end"
    assert shows("nmpc settled at t = 23.9 s, 0.076 deg at the end", printed)
    assert shows("nmpc settled at t = 23.70 s, ... at the end", printed)
    assert not shows("nmpc settled at t = 29.9 s, 0.0755 deg at the end", printed)
    assert not shows("pd settled at t = 23.70 s, 0.0755 deg at the end", printed)
