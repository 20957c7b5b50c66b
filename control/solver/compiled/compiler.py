"""A C compiler, if the machine has one, and a cache of what it made.

The library's name is a hash of all that decides its content: source, flags, compiler, processor.
It is written beside its final place and renamed, which is atomic: processes that start together
may compile it twice, but never load half of it.
"""

import atexit
import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
import warnings
from functools import lru_cache
from pathlib import Path

FLAGS = ("-O3", "-march=native", "-std=gnu11", "-fPIC", "-shared", "-w")
TIME_LIMIT = 300.0  # s; a compilation takes about two


def compiled_library(source: str) -> Path | None:
    """Path of the shared library made from C source, or None without a working compiler."""
    compiler = find_compiler()
    if compiler is None:
        return None
    content = "\0".join([source, *FLAGS, compiler, _version(compiler), _processor()])
    name = hashlib.sha256(content.encode()).hexdigest()[:24]
    library = cache_folder() / f"{name}.so"
    if library.exists():
        return library
    try:
        return _compile(compiler, source, library)
    except (OSError, subprocess.SubprocessError) as error:
        reason = getattr(error, "stderr", None) or str(error)
        warnings.warn(
            f"{compiler} could not compile the solver, which is interpreted instead, about twenty "
            f"times slower: {reason.strip().splitlines()[0]}",
            stacklevel=2,
        )
        return None


def find_compiler() -> str | None:
    """The first of cc, gcc and clang on the PATH."""
    found = (shutil.which(name) for name in ("cc", "gcc", "clang"))
    return next((path for path in found if path), None)


def cache_folder() -> Path:
    """Where libraries are kept: $XDG_CACHE_HOME/simsat, else ~/.cache/simsat."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "simsat"


def _compile(compiler: str, source: str, library: Path) -> Path:
    try:
        library.parent.mkdir(parents=True, exist_ok=True)
        folder = tempfile.mkdtemp(dir=library.parent)
    except OSError:  # no home, or a read-only one: compile for this process alone
        folder = tempfile.mkdtemp(prefix="simsat-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        library = Path(folder) / library.name
    draft = Path(folder) / "solver.so"
    code = Path(folder) / "solver.c"
    try:
        code.write_text(source)
        subprocess.run(
            [compiler, *FLAGS, "-o", str(draft), str(code), "-lm"],
            check=True,
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT,
        )
        os.replace(draft, library)
    finally:
        if library.parent != Path(folder):
            shutil.rmtree(folder, ignore_errors=True)
    return library


@lru_cache(maxsize=4)
def _version(compiler: str) -> str:
    answer = subprocess.run([compiler, "--version"], capture_output=True, text=True, timeout=10.0)
    return answer.stdout


@lru_cache(maxsize=1)
def _processor() -> str:
    """What -march=native depends on: a home directory may be shared between machines."""
    try:
        with open("/proc/cpuinfo") as file:
            lines = [line for line in file if line.startswith(("flags", "Features", "model name"))]
    except OSError:
        lines = [platform.processor()]
    return platform.machine() + "".join(sorted(set(lines)))
