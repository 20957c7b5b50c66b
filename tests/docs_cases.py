"""What tests of documents need: running a script or command as a user would, and comparing what it
prints with what is shown."""

import math
import os
import re
import subprocess
import sys
from pathlib import Path

from tests.places import ROOT

EXAMPLES = ROOT / "docs" / "examples"
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?")
NEARLY, SMALL = 0.05, 2e-3  # a flight's figures differ a little from one processor to another


def python(folder: Path, *words: str) -> str:
    """What Python prints when started in a folder with our packages on its path."""
    answer = subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


def shows(shown: str, printed: str) -> bool:
    """Whether some printed line is the shown one: the same words, and nearly the same numbers.

    `...` in the shown line stands for anything, after its last number.
    """
    return any(_alike(shown, line) for line in printed.splitlines())


def _alike(shown: str, line: str) -> bool:
    words = " ".join(NUMBER.sub("\0", shown).split())
    pattern = re.escape(words).replace(re.escape("..."), ".*")
    if not re.fullmatch(pattern, " ".join(NUMBER.sub("\0", line).split())):
        return False
    wanted, found = ([float(n) for n in NUMBER.findall(text)] for text in (shown, line))
    return all(
        math.isclose(a, b, rel_tol=NEARLY, abs_tol=SMALL)
        for a, b in zip(wanted, found, strict=False)
    )
