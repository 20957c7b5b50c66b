"""A library made from C source, loaded: from the cache, or compiled; or none, with a word.

Nothing that goes wrong here stops a flight. Without a cache folder that can be used (another
user's, read-only, full) the process compiles for itself; without a compiler that works the problem
is interpreted. A compiler that hangs is given up after its time limit: two minutes for each problem
are lost that way, and five at the very worst.
"""

import ctypes
import hashlib
import os
import sys
import tempfile
import warnings
from functools import lru_cache
from pathlib import Path
from typing import Any

from .cache import cache_folder, find_library, keep_library, throw_away
from .compiler import (
    ANSWER_LIMIT,
    CompilerError,
    CompilerTimeoutError,
    compile_library,
    compiler_identity,
    find_compiler,
    run_program,
)

TRIAL = "import ctypes, sys; ctypes.CDLL(sys.argv[1])"


def load_library(source: str, exports: tuple[str, ...]) -> Any | None:
    """The library made from C source, which defines all of `exports`, loaded.

    None without a compiler that works, with a warning that says why if there seemed to be one.
    """
    compiler = find_compiler()
    return None if compiler is None else _load_once(compiler, source, exports)


@lru_cache(maxsize=16)
def _load_once(compiler: str, source: str, exports: tuple[str, ...]) -> Any | None:
    try:
        content = "\0".join([compiler_identity(compiler), source])
        key = hashlib.sha256(content.encode(errors="surrogateescape")).hexdigest()[:24]
        return _load(compiler, source, exports, key)
    except CompilerError as reason:
        _warn(f"the solver is interpreted, about ten times slower, because {reason}")
        return None


def _load(compiler: str, source: str, exports: tuple[str, ...], key: str) -> Any:
    try:
        folder = cache_folder()
        library = _load_kept(folder, key)
        if library is not None:
            return library
        with _build_folder(folder) as build:
            draft = compile_library(compiler, source, Path(build))
            library = _load_new(draft, exports)
            keep_library(draft, folder, key)
            return library
    except CompilerTimeoutError:
        raise
    except (OSError, CompilerError) as trouble:  # a full disk makes the compiler fail
        library = _load_own(compiler, source, exports)
        _warn(f"this process compiled the solver for itself alone, because {_clause(trouble)}")
        return library


def _load_kept(folder: Path, key: str) -> Any | None:
    path = find_library(folder, key)
    if path is None:
        return None
    try:
        return ctypes.CDLL(str(path))
    except OSError:  # another process has just thrown it away, or what it needs is gone
        throw_away(path)
        return None


def _load_new(draft: Path, exports: tuple[str, ...]) -> Any:
    """A library that no process has loaded yet: first another one does, which it may crash."""
    try:
        if os.access(sys.executable, os.X_OK):  # not where Python is a part of another program
            run_program([sys.executable, "-I", "-S", "-c", TRIAL, str(draft)], ANSWER_LIMIT)
        library = ctypes.CDLL(str(draft))
    except (OSError, CompilerError) as error:
        raise CompilerError(f"what the compiler made cannot be loaded: {error}") from error
    missing = [name for name in exports if not hasattr(library, name)]
    if missing:
        raise CompilerError(f"what the compiler made lacks {missing[0]}")
    return library


def _load_own(compiler: str, source: str, exports: tuple[str, ...]) -> Any:
    """Without a cache. The files go at once; what is loaded stays."""
    try:
        with _build_folder(None) as build:
            return _load_new(compile_library(compiler, source, Path(build)), exports)
    except OSError as error:
        raise CompilerError(f"there is no place to compile it in: {_clause(error)}") from error


def _build_folder(parent: Path | None) -> Any:
    return tempfile.TemporaryDirectory(prefix="simsat-", dir=parent, ignore_cleanup_errors=True)


def _clause(trouble: Exception) -> str:
    """What went wrong and, if the system knows it, where."""
    if isinstance(trouble, OSError) and trouble.strerror:
        return ": ".join(str(part) for part in (trouble.filename, trouble.strerror) if part)
    return str(trouble)


def _warn(sentence: str) -> None:
    warnings.warn(sentence[0].upper() + sentence[1:], stacklevel=4)
