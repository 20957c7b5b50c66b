"""A model's identity follows what MuJoCo flies: includes and assets, not where the files lie."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from simsat.mjcf import read_model
from tests.places import MODELS, ROOT

TETRAHEDRON = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def copied(folder: Path) -> Path:
    """two_wheel with its includes, and a mesh for decoration."""
    for name in ("two_wheel", "parts"):
        shutil.copytree(MODELS / name, folder / name)
    path = folder / "two_wheel" / "two_wheel.xml"
    (folder / "two_wheel" / "antenna.obj").write_text(TETRAHEDRON)
    text = path.read_text()
    asset = '<asset><mesh name="antenna" file="antenna.obj"/></asset>'
    text = text.replace("<worldbody>", f"{asset}<worldbody>")
    geom = '<geom type="mesh" mesh="antenna" class="decoration"/>'
    path.write_text(text.replace('<body name="rotor_x"', f'{geom}<body name="rotor_x"'))
    return path


def test_it_is_the_same_in_another_place_and_in_another_process(tmp_path: Path) -> None:
    here = read_model(copied(tmp_path / "here")).identity
    there = copied(tmp_path / "there" / "deeper").rename(
        tmp_path / "there" / "deeper" / "two_wheel" / "renamed.xml"
    )
    assert read_model(there).identity == here
    script = f"from simsat.mjcf import read_model; print(read_model({str(there)!r}).identity)"
    said = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert said.stdout.strip() == here


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("parts/wheels.xml", "-0.05 0.05", "-0.050000001 0.050000001"),  # an included file's limit
        ("parts/wheels.xml", 'data="6000"', 'data="6001"'),  # and its own number
        ("two_wheel/antenna.obj", "v .1 0 0", "v .11 0 0"),  # an asset
        ("two_wheel/two_wheel.xml", 'data="2.2"', 'data="2.3"'),
        ("two_wheel/two_wheel.xml", 'name="motor_x"', 'name="motor_1"'),
    ],
)
def test_it_follows_every_file_that_the_model_is_made_of(
    tmp_path: Path, name: str, old: str, new: str
) -> None:
    path = copied(tmp_path)
    before = read_model(path).identity
    text = (tmp_path / name).read_text()
    assert old in text
    (tmp_path / name).write_text(text.replace(old, new))
    later = (tmp_path / name).stat().st_mtime + 10.0  # MuJoCo keeps assets by the second, in memory
    os.utime(tmp_path / name, (later, later))
    assert read_model(path).identity != before


def test_it_leaves_out_what_says_the_same(tmp_path: Path) -> None:
    path = copied(tmp_path)
    before = read_model(path).identity
    space = tmp_path / "parts" / "space.xml"
    space.write_text(space.read_text().replace('timestep="0.01"', 'timestep="1e-2"'))
    assert "1e-2" in space.read_text()
    assert read_model(path).identity == before
