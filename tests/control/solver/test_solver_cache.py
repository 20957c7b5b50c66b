"""The cache of compiled libraries: ours alone, checked, bounded, and shared by processes."""

import hashlib
import os
import signal
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from simsat.control.solver.compiled import cache as kept
from simsat.control.solver.compiled.cache import cache_folder, find_library, keep_library
from simsat.control.solver.compiled.library import load_library
from tests.compiler_cases import (
    EXPORTS,
    answer_of,
    answers,
    false_compiler,
    needs_compiler,
    start_loading,
)

ALONE = "This process compiled the solver for itself alone, because "


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "simsat"


# ---- whose folder it is ---------------------------------------------------------------------


def test_the_folder_is_made_for_us_alone(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cache_folder() == cache
    assert cache.stat().st_mode & 0o777 == 0o700
    assert cache.parent.stat().st_mode & 0o777 == 0o700
    home = cache.parent.parent / "home"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    for ignored in ("", "relative"):
        monkeypatch.setenv("XDG_CACHE_HOME", ignored)
        assert cache_folder() == home / ".cache" / "simsat"


def test_a_cache_that_lies_elsewhere_is_followed(cache: Path, tmp_path: Path) -> None:
    (tmp_path / "scratch").mkdir()
    cache.parent.symlink_to(tmp_path / "scratch")
    assert cache_folder() == tmp_path / "scratch" / "simsat"


def _link(cache: Path) -> None:
    (cache.parent / "elsewhere").mkdir()
    cache.rmdir()
    cache.symlink_to(cache.parent / "elsewhere")


def _file(cache: Path) -> None:
    cache.rmdir()
    cache.write_text("")


SPOILS: dict[str, Callable[[Path], None]] = {
    "is not a folder": _link,
    "simsat is not a folder": _file,
    "or others may write to it": lambda cache: cache.chmod(0o770),
    "simsat is another user's, or others": lambda cache: cache.chmod(0o702),
    "everybody may write to .*cache$": lambda cache: cache.parent.chmod(0o777),
}


@pytest.mark.parametrize("reason", SPOILS)
def test_a_folder_that_others_may_change_is_not_used(cache: Path, reason: str) -> None:
    cache_folder()
    SPOILS[reason](cache)
    with pytest.raises(OSError, match=reason):
        cache_folder()


def test_a_sticky_folder_above_keeps_ours_in_place(cache: Path) -> None:
    cache_folder()
    cache.parent.chmod(0o1777)
    assert cache_folder() == cache


@pytest.mark.parametrize("owned", ["simsat", "cache"])
def test_another_users_folder_is_not_used(
    cache: Path, monkeypatch: pytest.MonkeyPatch, owned: str
) -> None:
    """As another user sees it: to root all other users are strangers, to them not root."""
    folder = cache_folder()
    stranger = folder if owned == "simsat" else folder.parent
    true_stat = Path.stat

    def stranger_stat(path: Path, **options: bool) -> os.stat_result:
        info = list(true_stat(path, **options))
        if path == stranger:
            info[4] = 12345  # st_uid
        return os.stat_result(info)

    monkeypatch.setattr(Path, "stat", stranger_stat)
    with pytest.raises(OSError, match=f"{owned} is another user's"):
        cache_folder()


@needs_compiler
@pytest.mark.parametrize(("home", "reason"), [("/dev/null", "Not a dir"), ("/proc/1", "No such")])
def test_where_nothing_can_be_kept_a_process_compiles_for_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, home: str, reason: str
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", home)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    source = answers(42, tmp_path)
    with pytest.warns(UserWarning, match=f"^{ALONE}.*{reason}"):
        library = load_library(source, EXPORTS)
    assert library is not None
    assert library.answer() == 42
    assert load_library(source, EXPORTS) is library  # and says nothing more
    assert list(tmp_path.iterdir()) == []


@needs_compiler
def test_on_a_full_disk_a_process_compiles_elsewhere(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = 'echo "ld: error: No space left on device" >&2; exit 1'
    false_compiler(tmp_path, f'case $out in {cache}/*) {full};; esac; exec "$real" "$@"')
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    with pytest.warns(UserWarning, match=f"^{ALONE}.*cc failed: ld: error: No space left"):
        library = load_library(answers(42), EXPORTS)
    assert library is not None
    assert library.answer() == 42
    assert list(cache.iterdir()) == []


# ---- what is in it ----------------------------------------------------------------------------


def _rewritten(change: Callable[[bytes], bytes]) -> Callable[[Path], None]:
    def damage(path: Path) -> None:
        content = change(path.read_bytes())
        path.unlink()  # this process has loaded it: it keeps its own
        path.write_bytes(content)

    return damage


def _bit_turned(content: bytes) -> bytes:
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 4]) + content[middle + 1 :]


def _replaced(make: Callable[[Path], object]) -> Callable[[Path], None]:
    def damage(path: Path) -> None:
        path.rename(path.with_name("moved"))
        make(path)

    return damage


DAMAGES: dict[str, Callable[[Path], None]] = {
    "empty": _rewritten(lambda content: b""),
    "truncated": _rewritten(lambda content: content[:12000]),
    "zeros": _rewritten(lambda content: bytes(len(content))),
    "bit": _rewritten(_bit_turned),
    "arm": _rewritten(lambda content: content[:18] + b"\x28\0" + content[20:]),
    "link": _replaced(lambda path: path.symlink_to("moved")),
    "pipe": _replaced(os.mkfifo),
    "open to all": lambda path: path.chmod(0o666),
    "gone": Path.unlink,
}


@needs_compiler
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_library_heals(cache: Path, damage: str) -> None:
    """Another process, in which warnings are errors, compiles it anew; as whole as before."""
    source = answers(42, cache)
    load_library(source, EXPORTS)
    (path,) = cache.iterdir()
    DAMAGES[damage](path)
    assert answer_of(start_loading(source, "-W", "error")) == "42"
    assert find_library(cache, path.name.split("-")[0]) == path
    assert path.lstat().st_mode == stat.S_IFREG | 0o600


@needs_compiler
def test_a_whole_library_that_does_not_load_heals(cache: Path) -> None:
    source = answers(42, cache)
    load_library(source, EXPORTS)
    (path,) = cache.iterdir()
    key, content = path.name.split("-")[0], b"what only looks like a library"
    path.unlink()
    wrong = cache / f"{key}-{hashlib.sha256(content).hexdigest()}.so"
    wrong.write_bytes(content)
    wrong.chmod(0o600)
    assert find_library(cache, key) == wrong
    assert answer_of(start_loading(source, "-W", "error")) == "42"
    assert list(cache.iterdir()) == [path]


@needs_compiler
def test_what_is_kept_is_not_compiled_again(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "compiled"
    false_compiler(tmp_path, f'[ -z "$out" ] || echo "$out" >> {log}; exec "$real" "$@"')
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    for number in (42, 42, 43, 42):
        assert answer_of(start_loading(answers(number))) == str(number)
    assert len(log.read_text().splitlines()) == 2
    assert len(list(cache.iterdir())) == 2


def test_what_was_not_used_for_longest_goes_first(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three of 400 bytes where 1000 are kept; the oldest has been asked for since."""
    monkeypatch.setattr(kept, "KEPT", 1000)
    folder = cache_folder()
    for age, key in enumerate(("new", "old")):
        keep_library(_draft(tmp_path, key), folder, key)
        (path,) = folder.glob(f"{key}-*")
        os.utime(path, (0.0, 1e9 - age))
    assert find_library(folder, "old") is not None
    keep_library(_draft(tmp_path, "third"), folder, "third")
    assert {path.name.split("-")[0] for path in folder.iterdir()} == {"old", "third"}


def _draft(folder: Path, name: str) -> Path:
    path = folder / "draft.so"
    path.write_bytes(name.encode().ljust(400))
    return path


def test_old_build_folders_go_and_all_else_stays(cache: Path, tmp_path: Path) -> None:
    folder = cache_folder()
    for name in ("old", "young"):
        (folder / name).mkdir()
        (folder / name / "solver.c").write_text("")
    (folder / "note.txt").write_text("")
    os.utime(folder / "old", (0.0, 1e9))
    os.utime(folder / "note.txt", (0.0, 1e9))
    keep_library(_draft(tmp_path, "key"), folder, "key")
    assert {path.name.split("-")[0] for path in folder.iterdir()} == {"young", "note.txt", "key"}


# ---- who shares it ----------------------------------------------------------------------------


@needs_compiler
def test_processes_that_start_together_share_one_whole_library(cache: Path) -> None:
    """They find a damaged one, too."""
    source = answers(42, cache)
    load_library(source, EXPORTS)
    (path,) = cache.iterdir()
    DAMAGES["truncated"](path)
    running = [start_loading(source, "-W", "error") for _ in range(4)]
    assert [answer_of(process) for process in running] == ["42"] * 4
    assert find_library(cache, path.name.split("-")[0]) is not None
    assert {path.suffix for path in cache.iterdir()} == {".so"}


@needs_compiler
def test_a_process_killed_while_it_compiles_harms_no_other(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    slow = f'[ -z "$out" ] || {{ echo > "$out"; echo $$ > {pipe}; exec sleep 1000; }}'
    false_compiler(tmp_path, f'{slow}; exec "$real" "$@"')
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    victim = start_loading(answers(42))
    compiling = int(pipe.read_text())
    victim.kill()
    os.kill(compiling, signal.SIGKILL)
    assert answer_of(victim) == ""
    (left,) = cache.iterdir()
    assert (left / "solver.so").exists()
    false_compiler(tmp_path, 'exec "$real" "$@"')
    running = [start_loading(answers(42), "-W", "error") for _ in range(2)]
    assert [answer_of(process) for process in running] == ["42", "42"]
    os.utime(left, (0.0, 1e9))
    assert answer_of(start_loading(answers(43), "-W", "error")) == "43"
    assert not left.exists()
