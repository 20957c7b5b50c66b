"""Compilers: none, and every way to fail; each is done without, with one sentence."""

import os
import re
import select
import warnings
from pathlib import Path

import numpy as np
import pytest

from simsat.control.solver import SolverSettings, solve_ocp, solver_of
from simsat.control.solver.compiled import compiler, library
from simsat.control.solver.compiled.compiler import find_compiler
from simsat.control.solver.interpreted import InterpretedSolver
from tests.compiler_cases import EXPORTS, answers, false_compiler, needs_compiler
from tests.ocp_cases import double_integrator

CANNOT_LOAD = "what the compiler made cannot be loaded: "


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "simsat"


def refusal(folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Why the folder's compiler is done without, from the only sentence said."""
    monkeypatch.setenv("PATH", str(folder), prepend=os.pathsep)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert library.load_library(answers(42), EXPORTS) is None
    assert len(said) == 1
    sentence = str(said[0].message)
    beginning = "The solver is interpreted, about ten times slower, because "
    assert sentence.startswith(beginning)
    assert sentence.isprintable()
    return sentence.removeprefix(beginning)


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


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("echo 'solver.c: In g:' >&2; echo 'error: no cc1' >&2; exit 1", "failed: error: no cc1"),
        ("exit 3", "failed: exit code 3, and not a word"),
        ("echo '  ' >&2; exit 1", "failed: exit code 1, and not a word"),
        (r"printf '\n\377\000\033\007why\n' >&2; exit 1", "failed: why"),
        ("head -c 9999 /dev/zero | tr '\\0' x >&2; exit 1", "failed: x{200}"),
        ("kill -9 $$", "was killed by signal 9"),
    ],
)
@pytest.mark.parametrize("version", [True, False])
def test_a_compiler_that_fails_is_done_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, reason: str, version: bool
) -> None:
    """Asked for its version, or only when it is to compile."""
    path = false_compiler(tmp_path, script if version else f'[ -z "$out" ] || {{ {script}; }}')
    assert re.fullmatch(f"{path} {reason}", refusal(tmp_path, monkeypatch))


@needs_compiler
@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("", "reported success and wrote no library"),
        ('mkdir "$out"', "reported success and wrote no library"),
        (': > "$out"', CANNOT_LOAD + ".*file too short"),
        ('head -c 9999 /dev/zero > "$out"', CANNOT_LOAD + ".*invalid ELF header"),
        ('"$real" "$@"; head -c 12000 "$out" > "$out.t"; mv "$out.t" "$out"', CANNOT_LOAD),
        (  # another machine's: 40 is ARM
            '"$real" "$@"; printf "\\050\\000" | dd of="$out" bs=1 seek=18 conv=notrunc',
            CANNOT_LOAD + ".*cannot open shared object file",
        ),
        (
            'echo "int other;" | "$real" -shared -fPIC -x c -o "$out" -',
            "what the compiler made lacks answer",
        ),
        (
            'echo "void f(void); int answer(void) { f(); }"'
            ' | "$real" -shared -fPIC -w -x c -o "$out" -',
            CANNOT_LOAD + ".*undefined symbol: f",
        ),
        (
            'echo "__attribute__((constructor)) void f(void) { __builtin_trap(); }"'
            ' | "$real" -shared -fPIC -x c -o "$out" -',
            CANNOT_LOAD + ".*killed by signal",
        ),
    ],
)
def test_what_cannot_be_loaded_is_not_kept(
    tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch, script: str, reason: str
) -> None:
    false_compiler(tmp_path, f'[ -z "$out" ] && exit 0; {script or ":"}; exit 0')
    assert re.search(reason, refusal(tmp_path, monkeypatch))
    assert list(cache.iterdir()) == []


@pytest.mark.parametrize(
    ("content", "reason"),
    [(b"\177ELF\0", "Exec format error"), (b"#!/nowhere\n", "No such file or directory")],
)
def test_a_compiler_that_cannot_be_run_is_done_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: bytes, reason: str
) -> None:
    path = false_compiler(tmp_path, "")
    path.write_bytes(content)
    assert refusal(tmp_path, monkeypatch) == f"{path} cannot be run: {reason}"


@pytest.mark.parametrize("version", [True, False])
@pytest.mark.parametrize("how", ["sleep 1000 & wait", "sleep 1000 & exit 0", "exec sleep 1000"])
def test_a_compiler_that_hangs_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: bool, how: str
) -> None:
    """With all that it started: whatever held the pipe has closed it."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    script = f"exec 3>{pipe}; echo started >&3; {how}"
    path = false_compiler(tmp_path, script if version else f'[ -z "$out" ] || {{ {script}; }}')
    monkeypatch.setattr(compiler, "ANSWER_LIMIT" if version else "TIME_LIMIT", 1.0)
    assert refusal(tmp_path, monkeypatch) == f"{path} did not end in 1 s"
    assert os.read(reader, 100) == b"started\n"
    assert select.select([reader], [], [], 60.0)[0]
    assert os.read(reader, 1) == b""
    os.close(reader)
