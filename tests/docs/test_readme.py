"""Every command that the README shows is run, as shown, and its pictures exist."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.places import ROOT

README = (ROOT / "README.md").read_text()
LONG = ("simsat.campaign", "learning.train", "learning.data")  # minutes; their own tests run them


def commands() -> list[str]:
    """Lines of shell blocks that call our modules, continuation lines joined."""
    blocks = re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    lines = "\n".join(blocks).replace("\\\n", " ").splitlines()
    return [line.split("  #")[0].strip() for line in lines if line.startswith("python -m")]


def test_the_readme_shows_commands() -> None:
    assert any("simsat.run" in command for command in commands())


def test_the_commands_run_in_their_order(tmp_path: Path) -> None:
    """As a reader would: some go on with what others wrote."""
    for command in commands():
        if any(long in command for long in LONG):
            continue
        answer = subprocess.run(
            [sys.executable, *shlex.split(command)[1:]],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            capture_output=True, text=True, check=False, timeout=300,
        )  # fmt: skip
        assert answer.returncode == 0, f"{command}: {answer.stderr}"


@pytest.mark.parametrize("command", [c for c in commands() if any(x in c for x in LONG)])
def test_a_long_commands_flags_exist(command: str) -> None:
    """Commands that take minutes are not run here; their flags must be in --help."""
    words = shlex.split(command)
    answer = subprocess.run(
        [sys.executable, "-m", words[2], "--help"],
        cwd=ROOT, capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    for flag in (word for word in words if word.startswith("--")):
        assert flag in answer.stdout, f"{words[2]} has no {flag}"


def test_every_linked_file_exists() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)|src=\"([^\"]+)\"", README):
        name = target[0] or target[1]
        if not name.startswith("http"):
            assert (ROOT / name).exists(), f"README links {name}"


def test_the_python_snippet_prints_what_it_says(tmp_path: Path) -> None:
    snippet, printed = re.findall(r"```python\n(.*?)```\s+```\n(.*?)```", README, re.DOTALL)[0]
    (tmp_path / "readme.py").write_text(snippet)
    answer = subprocess.run(
        [sys.executable, "readme.py"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert answer.stdout == printed, answer.stderr
    assert (tmp_path / "pd" / "metrics.json").exists()
