"""Compilers that misbehave, and another process that loads a library."""

import subprocess
import sys
from pathlib import Path

import pytest

from simsat.control.solver.compiled.compiler import find_compiler

REAL = find_compiler()
EXPORTS = ("answer",)
LOAD = (
    "from simsat.control.solver.compiled.library import load_library;"
    "import sys; library = load_library(sys.argv[1], ('answer',));"
    "print(library.answer() if library else None)"
)

needs_compiler = pytest.mark.skipif(REAL is None, reason="no C compiler")


def answers(number: int, whose: object = "") -> str:
    """C source of a library with one function; what one test has loaded is new to `whose` else."""
    return f"/* {whose} */ int answer(void) {{ return {number}; }}"


def start_loading(source: str, *options: str) -> "subprocess.Popen[str]":
    """A process that loads a library and prints its answer; `options` are Python's."""
    command = [sys.executable, *options, "-c", LOAD, source]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)


def answer_of(process: "subprocess.Popen[str]") -> str:
    """What it printed; one that crashed printed nothing."""
    return process.communicate(timeout=120)[0].strip()


def false_compiler(folder: Path, script: str) -> Path:
    """A program `cc` of shell commands in a folder for the PATH.

    There `$real` is the true compiler and `$out` the file that is asked for, empty when only the
    version is.
    """
    head = [
        "#!/bin/sh",
        f"real={REAL}",
        'out=; last=; for word; do [ "$last" = -o ] && out=$word; last=$word; done',
    ]
    path = folder / "cc"
    path.write_text("\n".join([*head, script, ""]))
    path.chmod(0o755)
    return path
