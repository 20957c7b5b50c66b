"""Where compiled libraries are kept: a folder of our own, each file checked before it is loaded.

Who can write a library runs code as us, so the folder must be ours alone, and nobody may be able to
put another in its place. A library is named `key-checksum.so`: what it was made from, and the
SHA-256 of its bytes. One that does not match its name (cut short, filled with zeros, one bit
turned) is thrown away, and made anew by whoever asked for it. A file appears under its name whole
or not at all, since renaming is atomic; processes that start together may make it twice.
"""

import hashlib
import os
import shutil
import stat
from contextlib import suppress
from pathlib import Path

KEPT = 64 * 2**20  # bytes; a library has 0.2 MB, so some 300 problems, more than a year asks for
LEFTOVER_AGE = 3600.0  # s; thirty times the longest compilation
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


class UntrustedFolderError(OSError):
    """The cache folder is not ours alone; the text says why."""


def cache_folder() -> Path:
    """$XDG_CACHE_HOME/simsat, else ~/.cache/simsat, made with mode 0700 where it is missing.

    Raises `UntrustedFolderError` where another user owns it, may write to it, or could swap it (a
    folder above it is another user's, or writable by all without the sticky bit; a group that may
    write above it is trusted), and OSError where it cannot be made.
    """
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):  # to be ignored, says the XDG specification
        base = os.path.expanduser("~/.cache")
    if not os.path.isabs(base):
        raise UntrustedFolderError("this user has no home")
    folder = Path(os.path.realpath(base)) / "simsat"
    for above in folder.parents:
        if above.is_dir():
            _refuse_strangers(above)
    _make(folder)
    info = folder.lstat()
    if not stat.S_ISDIR(info.st_mode):
        raise UntrustedFolderError(f"{folder} is not a folder")
    if not _is_ours(info):
        raise UntrustedFolderError(f"{folder} is another user's, or others may write to it")
    return folder


def find_library(folder: Path, key: str) -> Path | None:
    """The whole library of that key; what only looks like it is thrown away."""
    for path in folder.glob(f"{key}-*.so"):
        if _is_whole(path):
            with suppress(OSError):  # a cache that is read-only for now still serves
                os.utime(path)  # the last use decides what `tidy` keeps
            return path
        throw_away(path)
    return None


def keep_library(draft: Path, folder: Path, key: str) -> None:
    """Move a new library, made on the same file system, to its name in the folder."""
    draft.chmod(0o600)
    kept = folder / f"{key}-{hashlib.sha256(draft.read_bytes()).hexdigest()}.so"
    os.replace(draft, kept)
    with suppress(OSError):  # another process tidies too
        _tidy(folder, now=kept.stat().st_mtime)


def throw_away(path: Path) -> None:
    """Remove a library, if that can be done."""
    with suppress(OSError):
        path.unlink()


def _refuse_strangers(above: Path) -> None:
    info = above.stat()
    if info.st_uid not in (0, os.geteuid()):
        raise UntrustedFolderError(f"{above} is another user's")
    if info.st_mode & stat.S_IWOTH and not info.st_mode & stat.S_ISVTX:
        raise UntrustedFolderError(f"everybody may write to {above}")


def _make(folder: Path) -> None:
    if not folder.parent.exists():
        _make(folder.parent)
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)


def _is_ours(info: os.stat_result) -> bool:
    return info.st_uid == os.geteuid() and not info.st_mode & OTHERS_WRITE


def _is_whole(path: Path) -> bool:
    """Whether a library is our own file and has the bytes that its name promises."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with open(descriptor, "rb") as file:
            info = os.fstat(descriptor)
            if not (stat.S_ISREG(info.st_mode) and _is_ours(info) and info.st_size <= KEPT):
                return False
            return path.stem.endswith("-" + hashlib.sha256(file.read()).hexdigest())
    except OSError:
        return False


def _tidy(folder: Path, now: float) -> None:
    """Remove what killed processes left, and the libraries that were not used for longest."""
    for path in folder.iterdir():
        if path.is_dir() and now - path.lstat().st_mtime > LEFTOVER_AGE:
            shutil.rmtree(path, ignore_errors=True)
    size = 0
    for path in sorted(folder.glob("*.so"), key=lambda path: path.lstat().st_mtime, reverse=True):
        size += path.lstat().st_size
        if size > KEPT:
            throw_away(path)
