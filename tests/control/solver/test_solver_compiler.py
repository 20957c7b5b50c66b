"""The compiler and its cache: none, broken, read-only, and several processes at once."""

import ctypes
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from simsat.control.solver import SolverSettings, solve_ocp, solver_of
from simsat.control.solver.compiled.compiler import cache_folder, compiled_library, find_compiler
from simsat.control.solver.interpreted import InterpretedSolver
from tests.ocp_cases import double_integrator

SOURCE = "int answer(void) { return 42; }"
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "simsat"


@needs_compiler
def test_a_library_is_compiled_once(empty_cache: Path) -> None:
    assert cache_folder() == empty_cache
    library = compiled_library(SOURCE)
    assert library is not None
    assert ctypes.CDLL(str(library)).answer() == 42
    written = library.stat().st_mtime_ns
    assert compiled_library(SOURCE) == library
    assert library.stat().st_mtime_ns == written
    other = compiled_library(SOURCE.replace("42", "43"))
    assert other is not None
    assert other != library
    assert sorted(empty_cache.iterdir()) == sorted([library, other])


@needs_compiler
def test_processes_that_start_together_share_one_whole_library(empty_cache: Path) -> None:
    code = (
        "import ctypes; from simsat.control.solver.compiled.compiler import compiled_library;"
        f"print(ctypes.CDLL(str(compiled_library({SOURCE!r}))).answer())"
    )
    command = [sys.executable, "-c", code]
    running = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(3)]
    assert [process.communicate(timeout=120)[0].strip() for process in running] == ["42"] * 3
    assert [path.suffix for path in empty_cache.iterdir()] == [".so"]


@needs_compiler
def test_without_a_cache_folder_the_process_compiles_for_itself(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    library = compiled_library(SOURCE)
    assert library is not None
    assert ctypes.CDLL(str(library)).answer() == 42


def test_without_a_compiler_the_problem_is_interpreted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_compiler = double_integrator()
    x0, guess, p = np.array([2.0, -0.5]), np.zeros((15, 1)), np.zeros(1)
    expected = solve_ocp(with_compiler, x0, guess, p)
    monkeypatch.setenv("PATH", str(tmp_path))
    without = double_integrator()
    assert find_compiler() is None
    assert isinstance(solver_of(without, "auto"), InterpretedSolver)
    solution = solve_ocp(without, x0, guess, p, SolverSettings())
    np.testing.assert_allclose(solution.u, expected.u, atol=1e-9)


def test_a_broken_compiler_is_named_and_done_without(
    tmp_path: Path, empty_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\necho 'cc1 is not installed' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path) + os.pathsep + "/bin")
    with pytest.warns(UserWarning, match="cc could not compile the solver.*cc1 is not installed"):
        assert compiled_library(SOURCE) is None
    assert list(empty_cache.iterdir()) == []
