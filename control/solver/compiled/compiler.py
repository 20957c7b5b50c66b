"""A C compiler, if the machine has one: run within a time limit, and blamed in one clause."""

import os
import platform
import shutil
import signal
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

FLAGS = ("-O3", "-march=native", "-std=gnu11", "-fPIC", "-shared", "-w")
TIME_LIMIT = 120.0  # s; a compilation takes about two, sixty times that on a crowded machine
ANSWER_LIMIT = 20.0  # s; for what ends at once
COMPLAINT = 200  # characters of a compiler's complaint are enough


class CompilerError(Exception):
    """The compiler made no library; the text is a clause that says why."""


class CompilerTimeoutError(CompilerError):
    """It had not ended within its time limit."""


def find_compiler() -> str | None:
    """The first of cc, gcc and clang on the PATH."""
    found = (shutil.which(name) for name in ("cc", "gcc", "clang"))
    return next((path for path in found if path), None)


def compile_library(compiler: str, source: str, folder: Path) -> Path:
    """The shared library made from C source, in a folder that exists; all else is left there too.

    Raises `CompilerError`, after `TIME_LIMIT` at the latest, and OSError where the source cannot
    be written.
    """
    code, library = folder / "solver.c", folder / "solver.so"
    code.write_text(source)
    command = [compiler, *FLAGS, "-o", str(library), str(code), "-lm"]
    run_program(command, TIME_LIMIT, scratch=folder)
    if not library.is_file():
        raise CompilerError(f"{compiler} reported success and wrote no library")
    return library


@lru_cache(maxsize=4)
def compiler_identity(compiler: str) -> str:
    """All beside the source that decides a library's content: flags, compiler, processor."""
    version = run_program([compiler, "--version"], ANSWER_LIMIT)
    return "\0".join([*FLAGS, compiler, version, _processor()])


def run_program(command: Sequence[str], limit: float, scratch: Path | None = None) -> str:
    """What a program wrote to its standard output; its temporary files go to `scratch`.

    Raises `CompilerError` where it cannot be run, fails, or runs for longer than `limit` seconds;
    then it is stopped, with all that it started.
    """
    places = {} if scratch is None else {"TMPDIR": str(scratch)}
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | {"LC_ALL": "C"} | places,
            start_new_session=True,
        )
    except OSError as error:
        raise CompilerError(f"{command[0]} cannot be run: {error.strerror}") from error
    with process:
        try:
            output, complaint = process.communicate(timeout=limit)
        except BaseException as error:  # an interrupt as well
            with suppress(OSError):
                os.killpg(process.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                raise CompilerTimeoutError(f"{command[0]} did not end in {limit:g} s") from error
            raise
    if process.returncode < 0:
        raise CompilerError(f"{command[0]} was killed by signal {-process.returncode}")
    if process.returncode > 0:
        raise CompilerError(f"{command[0]} failed: {_reason(complaint, process.returncode)}")
    return output.decode(errors="replace")


def _reason(complaint: bytes, code: int) -> str:
    """The line that tells most, printable and short."""
    text = complaint.decode("ascii", errors="ignore")
    printable = ("".join(filter(str.isprintable, line)).strip() for line in text.splitlines())
    lines = [line for line in printable if line]
    telling = [line for line in lines if "error" in line.lower()] + lines
    return telling[0][:COMPLAINT] if telling else f"exit code {code}, and not a word"


@lru_cache(maxsize=1)
def _processor() -> str:
    """What -march=native depends on: a home directory may be shared between machines."""
    try:
        with open("/proc/cpuinfo") as file:
            lines = [line for line in file if line.startswith(("flags", "Features", "model name"))]
    except OSError:
        lines = [platform.processor()]
    return platform.machine() + "".join(sorted(set(lines)))
