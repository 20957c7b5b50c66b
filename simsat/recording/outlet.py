"""The way of a recording to its file: through a pipe, so that a full disk is ours to notice.

rerun writes in a thread of its own. Where writing fails that thread ends, and whoever waits for it
then, to flush or to close, may wait for ever (rerun 0.41). A pipe never fails.
"""

import contextlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path

AT_ONCE = 1 << 16  # bytes; what a pipe holds


class Outlet:
    """A pipe to write to, and a thread that carries what arrives to the file.

    A file that can't be written any further is removed, to leave others the room, and the rest is
    thrown away.
    """

    def __init__(self, path: Path):
        self._path = path
        self._reader, self._writer = os.pipe()
        self._thread = threading.Thread(target=self._carry, name="recording", daemon=True)
        self.lost = False
        """Whether the file is gone."""
        self._thread.start()

    @property
    def name(self) -> str:
        """The pipe as a file to open."""
        return f"/dev/fd/{self._writer}"

    def taken(self) -> None:
        """The writer has opened the pipe: once it closes it, nothing more can come."""
        os.close(self._writer)

    def close(self) -> None:
        """Wait until everything has arrived; the writer must have closed the pipe."""
        self._thread.join()

    def _carry(self) -> None:
        try:
            with self._path.open("wb", buffering=0) as file:  # a kill loses nothing that arrived
                for content in self._arriving():
                    while content:
                        content = content[file.write(content) :]
        except OSError:
            self.lost = True
            with contextlib.suppress(OSError):
                self._path.unlink(missing_ok=True)
            for _ in self._arriving():
                pass
        os.close(self._reader)

    def _arriving(self) -> Iterator[memoryview]:
        while content := os.read(self._reader, AT_ONCE):
            yield memoryview(content)
