"""One process at a time in a folder: a lock that the operating system drops with its process."""

import contextlib
import errno
import os
import platform
import sys
from collections.abc import Iterator
from pathlib import Path

from simsat.control.ground.errors import OutputError

LOCK = "lock"
NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)  # of a file system without


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the folder; the file stays, its lock ends with the block or with the process.

    Where the file system knows no locks, a warning says so. Raises `OutputError` if another process
    holds the folder or nothing can be written in it.
    """
    path = folder / LOCK
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise OutputError(f"can't write in the folder '{folder}': {error.strerror}") from error
    try:
        _take(handle, folder)
        with contextlib.suppress(OSError):  # a full disk: who holds it is for messages only
            os.ftruncate(handle, 0)
            os.pwrite(handle, f"process {os.getpid()} on {platform.node()}\n".encode(), 0)
        yield
    finally:
        os.close(handle)


def _take(handle: int, folder: Path) -> None:
    try:
        import fcntl  # POSIX only

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        holder = os.pread(handle, 200, 0).decode(errors="replace").strip() or "another process"
        raise OutputError(
            f"'{folder}' is in use by {holder}: wait until it has ended, or choose another --out"
        ) from None
    except (ImportError, OSError) as error:
        if isinstance(error, OSError) and error.errno not in NO_LOCKS:
            raise
        print(
            f"warning: '{folder}' can't be locked here; start nothing else in it",
            file=sys.stderr,
        )
