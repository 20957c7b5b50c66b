"""A few of the worst in processes of their own: what a shell sees."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.places import ROOT

WORST: dict[str, tuple[list[Any], str]] = {
    "newlines and colours": (
        ["run", "--controller", "a\nb\x1b[31m"],
        "no controller 'a b\\x1b[31m'",
    ),
    "no UTF-8": (["run", "--model", b"\xff"], "--model is '\\udcff'"),
    "a device": (["campaign", "--study", "/dev/zero"], "no study at '/dev/zero'"),
    "a name too long": (["run", "--model", "x" * 5000 + ".xml"], "no model file at"),
    "a number too long": (["run", "--controller", "9" * 50_000], "no controller '999"),
    "code that leaves": (["run", "--controller", "leaves:name"], "raised SystemExit: 0"),
    "code that leaves at once": (["run", "--controller", "gone:name"], "can't be imported: Sys"),
}


@pytest.mark.parametrize("name", WORST)
def test_a_shell_sees_one_line_and_exit_code_two(name: str, tmp_path: Path) -> None:
    (tmp_path / "leaves.py").write_text("def name(brief):\n    raise SystemExit(0)\n")
    (tmp_path / "gone.py").write_text("import sys\nsys.exit()\n")
    (command, *words), sentence = WORST[name]
    ended = subprocess.run(
        [sys.executable, "-m", f"simsat.{command}", *words],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        check=False,
    )
    err = ended.stderr.decode()
    assert ended.returncode == 2
    assert len(err.splitlines()) == 1
    assert err.startswith("error: ")
    assert sentence in err
