"""CONTRIBUTING.md is true: its drawing, its signposts, its example, its ritual."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.rooms import BUILDINGS, GUIDE, drawing, drawn
from tests.places import ROOT

TEXT = GUIDE.read_text()
SIGNPOST = re.compile(r"^\| .* \| `(\w+)` in \[[^\]]*\]\((\S+)\) \|$", re.MULTILINE)
SIGNPOSTS: list[tuple[str, str]] = SIGNPOST.findall(TEXT)
COMMANDS = re.findall(r"^ *(python -m .*)$", TEXT, re.MULTILINE)


def test_the_drawing_has_every_room_with_its_own_words() -> None:
    assert drawn(TEXT) == drawing(), "python -m tests.docs.rooms draws it anew"


def test_the_drawing_names_every_package_and_no_other() -> None:
    """Counted another way: by the files, whatever the drawing's lines look like."""
    names = re.findall(r"(\w+)/  ", drawn(TEXT))
    packages = [path.parent.name for top in BUILDINGS for path in (ROOT / top).rglob("__init__.py")]
    assert sorted(names) == sorted(["models", *packages])


@pytest.mark.parametrize(("name", "place"), SIGNPOSTS)
def test_what_a_signpost_names_is_where_it_points(name: str, place: str) -> None:
    assert re.search(
        rf"^\s*(def|class) {name}\b|^{name}\b.* = ", (ROOT / place).read_text(), re.MULTILINE
    )


def test_there_are_signposts() -> None:
    assert len(SIGNPOSTS) >= 15
    assert len(SIGNPOSTS) == TEXT.count(" in [")


def test_every_link_leads_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert (ROOT / target).exists(), target


def test_the_example_flies_and_converges(tmp_path: Path) -> None:
    code = re.search(r"```python\n(.*?)```", TEXT, re.DOTALL)
    assert code is not None
    (tmp_path / "mine.py").write_text(code[1])
    answer = call(next(c for c in COMMANDS if "mine:" in c), tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert re.search(r"converged +yes", answer.stdout)
    (metrics,) = tmp_path.glob("runs/*/metrics.json")
    assert '"mine:fastest_turn_deg_s"' in metrics.read_text()


def test_the_ritual_says_the_same_to_the_last_bit(tmp_path: Path) -> None:
    """With the ten flights cut to ten seconds each."""
    ritual = [c for c in COMMANDS if "runs/before" in c]
    assert len(ritual) == 2
    for command, more in zip(ritual, (" --duration-s 10", ""), strict=True):
        answer = call(command + more, tmp_path)
        assert answer.returncode == 0, answer.stderr
    assert "10 flown again: the same to the last bit" in answer.stdout


def call(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *shlex.split(command, comments=True)[1:]],
        cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False, timeout=250,
    )  # fmt: skip
