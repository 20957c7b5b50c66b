"""Refuses to build where the links inside simsat/ were lost; the rest is in pyproject.toml.

simsat/control, simsat/learning and simsat/models are links to the folders beside simsat/. Some
unzippers, and git on Windows without `core.symlinks`, leave a line of text in their place, and the
wheel would lack what it stands for.
"""

from pathlib import Path

from setuptools import setup

for room in ("control", "learning", "models"):
    if not (Path(__file__).parent / "simsat" / room).is_dir():
        raise SystemExit(
            f"simsat/{room} must be a link to the folder {room}/ but the link was lost; clone with "
            "git (on Windows: git config core.symlinks true), or unpack with tar or unzip"
        )

setup()
