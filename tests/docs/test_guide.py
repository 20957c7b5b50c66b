"""The guide "Change the spacecraft", followed to the letter: edits, commands, what comes out."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from simsat.mjcf.shipped import MODELS

ROOT = MODELS.parent
GUIDE = (MODELS / "README.md").read_text()
BLOCKS: list[tuple[str, str]] = re.findall(r"```(sh|diff|text)\n(.*?)```", GUIDE, re.DOTALL)


def run(line: str, folder: Path) -> str:
    """What a line of a shell block prints."""
    words = shlex.split(line)
    if words[0] == "python":
        words[0] = sys.executable
    answer = subprocess.run(
        words,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert answer.returncode == 0, f"{line}\n{answer.stderr}"
    return answer.stdout


def apply(diff: str, path: Path) -> None:
    """Replace the one place in the file that has the diff's context and removed lines."""
    lines = diff.splitlines(keepends=True)
    old = "".join(line[1:] for line in lines if line[0] in " -")
    new = "".join(line[1:] for line in lines if line[0] in " +")
    text = path.read_text()
    assert text.count(old) == 1, f"the file has {text.count(old)} places like\n{old}"
    path.write_text(text.replace(old, new))


def test_every_step_of_the_guide_does_what_it_says(tmp_path: Path) -> None:
    shutil.copytree(MODELS, tmp_path / "models")
    output = ""
    for kind, block in BLOCKS:
        if kind == "sh":
            output = "".join(run(line, tmp_path) for line in block.splitlines())
        elif kind == "diff":
            apply(block, tmp_path / "models" / "my_craft" / "my_craft.xml")
        else:
            printed = [line.split() for line in output.splitlines()]
            for line in block.splitlines():
                assert line.split() in printed, f"the guide shows\n{line}\nbut it prints\n{output}"


def test_the_guide_s_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)]+)\)", GUIDE):
        assert (MODELS / target).exists(), target
