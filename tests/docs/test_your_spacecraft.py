"""docs/your-spacecraft.md, followed to the letter, and the zoo's table against the models."""

import re
import shlex
from pathlib import Path

import pytest

from simsat.control.ground.settings import hints
from simsat.mjcf import read_model
from simsat.mjcf.shipped import MODELS, find_model, shipped_models
from simsat.writing.figures import PartFigures, WheelFigures, WholeFigures
from tests.docs_cases import python, shows
from tests.places import ROOT

GUIDE = (ROOT / "docs" / "your-spacecraft.md").read_text()
BLOCKS: list[tuple[str, str]] = re.findall(r"```(\w+)\n(.*?)```", GUIDE, re.DOTALL)
ROW = re.compile(r"^\| \[(\w+)\]\(\w+/README.md\), [^|]*\|(.*)\|$", re.MULTILINE)
SIZES = {name: cells.split("|") for name, cells in ROW.findall((MODELS / "README.md").read_text())}


def test_every_command_prints_what_the_guide_shows(tmp_path: Path) -> None:
    files = {"toml": "my_craft.toml", "csv": "wheels.csv"}
    printed, commands = "", 0
    for kind, block in BLOCKS:
        if kind in files:
            (tmp_path / files[kind]).write_text(block)
        elif kind == "xml" and block.startswith("<mujoco"):
            (tmp_path / "two_left.xml").write_text(block)
        elif kind == "sh":
            commands += 1
            printed = python(tmp_path, *shlex.split(block)[1:])
        elif kind == "text":
            for line in block.splitlines():
                assert shows(line, printed), f"the guide shows\n{line}\nbut it prints\n{printed}"
    assert commands == 4


def test_its_lines_of_custom_are_read(tmp_path: Path) -> None:
    lines = [block for kind, block in BLOCKS if kind == "xml" and block.startswith("<numeric")]
    assert len(lines) == 1
    path = tmp_path / "weak.xml"
    craft = MODELS / "aura" / "aura.xml"
    path.write_text(craft.read_text().replace("<custom>", f"<custom>{lines[0]}"))
    assert len(read_model(path).spacecraft.envelopes) == 3


def test_its_tables_have_every_key() -> None:
    for figures in (WholeFigures, WheelFigures, PartFigures):
        for name in hints(figures):
            assert f"`{name}`" in GUIDE, name


def test_its_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)]+)\)", GUIDE):
        assert (ROOT / "docs" / target).exists(), target


@pytest.mark.parametrize("name", SIZES)
def test_the_zoo_s_table_is_true(name: str) -> None:
    """Against the models: mass, J, wheels, limits, T0 = sqrt(J / u) with J the mean moment."""
    craft = read_model(find_model(name)).spacecraft
    mass, J, wheels, torque, stored, T0 = SIZES[name]
    assert float(mass) == pytest.approx(craft.mass, rel=1e-9)
    moments = [float(number) for number in J.split(",")]
    assert moments == pytest.approx(craft.J.diagonal().tolist(), rel=0.02)
    assert int(wheels) == craft.wheels
    assert float(torque) == pytest.approx(craft.torque_max.min(), rel=1e-6)
    assert float(stored) == pytest.approx(craft.momentum_max.min(), rel=3e-3)
    expected = (craft.J.diagonal().mean() / craft.torque_max.min()) ** 0.5
    assert float(T0) == pytest.approx(expected, rel=0.02)


def test_the_zoo_s_table_is_whole() -> None:
    variants = {name.removesuffix("_two_wheel") for name in shipped_models()
                if name.endswith("_two_wheel")}  # fmt: skip
    assert variants | {"two_wheel"} == SIZES.keys()
