"""MuJoCo's errors and warnings: one sentence of ours, nothing printed, no file left behind."""

import os
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from simsat.control.ground.errors import ModelError
from simsat.mjcf import read_compiled, read_model
from simsat.mjcf.shipped import find_model
from simsat.results.summary import describe
from tests.places import ROOT
from tests.simsat.mjcf.edits import FREE, at_end, joint_x, text

NAMED = (' name="wheel_x" class', ' name="wheel&#10;x" stiffness="1" armature="1" class')
DRIVEN = ('joint="wheel_x"', 'joint="wheel&#10;x"')

DIVERGE = """
import numpy as np
from simsat.control.ground.errors import DivergedError
from simsat.mjcf import read_compiled, read_model
from simsat.plant.plant import Plant
plant = Plant(read_model({path!r}), 0.05, 10)
plant.reset(np.array([1.0, 0, 0, 0]), np.full(3, 1e30))
try:
    plant.advance(np.zeros(2), 10)
except DivergedError:
    print("diverged")
"""


def written(folder: Path, xml: str) -> Path:
    path = folder / "craft.xml"
    path.write_text(xml)
    return path


@pytest.mark.parametrize(
    ("xml", "message"),
    [
        (text((FREE, "<freejoints/>")), r"craft\.xml': XML Error: .*freejoints.*line 14"),
        (
            text(joint_x(stiffnes="1")),
            r"unrecognized attribute: 'stiffnes' Element 'joint', line 30",
        ),
        (text(joint_x(limited="true", range="3 1")), r"Element name 'wheel_x'"),
        (text((' mass="48.4"', ' mass="-1"')), "mass"),
        (text(at_end('<size memory="1"/>')), "out of memory.*increase <size memory"),
        ("", r"craft\.xml': .*empty file"),
        ("<mujoco", r"craft\.xml': XML parse error.*Line number=1"),
        ("\0\x01", r"craft\.xml': XML parse error"),
    ],
)
def test_mujoco_s_errors_are_one_line_with_the_place(
    tmp_path: Path, xml: str, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ModelError, match=message) as refusal:
        read_model(written(tmp_path, xml))
    assert len(str(refusal.value).splitlines()) == 1
    assert capfd.readouterr() == ("", "")


def test_a_newline_in_a_name_breaks_no_line(tmp_path: Path) -> None:
    folder = tmp_path / "a\nb"
    folder.mkdir()
    with pytest.raises(ModelError, match=r"no model 'a b'; there are: ") as refusal:
        find_model("a\nb")
    assert len(str(refusal.value).splitlines()) == 1
    with pytest.raises(ModelError, match=r"/a b/craft.xml': 2 faults:") as refusal:
        read_model(written(folder, text(NAMED, DRIVEN)))
    _, *faults = str(refusal.value).splitlines()
    assert len(faults) == 2
    assert all(fault.startswith("  - ") and "'wheel x'" in fault for fault in faults)


def test_mujoco_s_warnings_are_said_and_not_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    model = read_model(written(tmp_path, text(at_end('<compiler settotalmass="50"/>'))))
    assert len(model.warnings) == 1
    assert "'settotalmass' is deprecated" in model.warnings[0]
    assert "  MuJoCo warns: compiler attribute" in describe(model, model.spacecraft)
    assert capfd.readouterr() == ("", "")
    assert os.listdir() == ["craft.xml"]
    assert mujoco.get_mju_user_warning() is None  # whoever listened before listens again


def test_a_nan_that_mujoco_only_warns_of_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="not finite, in <option timestep>"):
        read_model(written(tmp_path, text(at_end('<option timestep="nan"/>'))))
    harmless = at_end('<visual><headlight ambient="nan 0 0"/></visual>')
    with pytest.raises(ModelError, match="a number is given as 'nan'"):
        read_model(written(tmp_path, text(harmless)))


def test_a_flight_that_diverges_prints_nothing_and_leaves_no_file(tmp_path: Path) -> None:
    """In a process of its own: MuJoCo's warnings come from C and go to its own log."""
    path = written(tmp_path, text())
    answer = subprocess.run(
        [sys.executable, "-c", DIVERGE.format(path=str(path))],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    assert (answer.stdout, answer.stderr) == ("diverged\n", "")
    assert os.listdir(tmp_path) == ["craft.xml"]


@pytest.mark.parametrize("edit", [joint_x(damping="-1"), at_end('<option timestep="5e-9"/>')])
def test_the_command_line_says_it_once_and_ends_with_2(
    tmp_path: Path, edit: tuple[str, str]
) -> None:
    path = written(tmp_path, text(edit))
    answer = subprocess.run(
        [sys.executable, "-m", "simsat.run", "--model", str(path), "--no-recording"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert answer.returncode == 2
    assert answer.stdout == ""
    assert answer.stderr.startswith(f"error: '{path}': ")
    assert len(answer.stderr.splitlines()) == 1


MUSCLE = '<actuator><muscle name="arm" joint="wheel_x" {}/></actuator>'
ALL_LENGTHS = '<compiler><lengthrange mode="all" inttotal="1e7"/></compiler>'


@pytest.mark.parametrize(
    ("edits", "message"),
    [
        ([at_end(MUSCLE.format('armature="nan"'))], "not finite"),
        ([at_end(MUSCLE.format(""))], "actuator 'arm' is no torque motor"),
        ([at_end(ALL_LENGTHS), joint_x(damping="-1")], "feeds motion"),
    ],
)
def test_the_length_of_a_muscle_is_not_looked_for(
    tmp_path: Path, edits: list[tuple[str, str]], message: str
) -> None:
    """MuJoCo flies the model until it has it: the first and the last of these never came back."""
    with pytest.raises(ModelError, match=message):
        read_model(written(tmp_path, text(*edits)))


def test_finite_numbers_are_needed_before_anything_else(tmp_path: Path) -> None:
    """With a nan in it no other number of a model means anything: it alone is said."""
    xml = text(joint_x(damping="-1"), at_end('<option timestep="nan"/>'))
    with pytest.raises(ModelError, match="not finite") as refusal:
        read_model(written(tmp_path, xml))
    assert "feeds" not in str(refusal.value)
    assert np.isfinite(read_model(written(tmp_path, text())).spacecraft.J).all()


def test_a_compiled_model_that_mujoco_gives_up_on_is_refused() -> None:
    """Its tables of indices edited by hand, as no compiler writes them."""
    m = mujoco.MjModel.from_xml_string(text())
    m.D_rownnz[6] -= 1
    with pytest.raises(ModelError, match="MuJoCo gives up on it: checkDBSparse: rows have diff"):
        read_compiled(m)
