"""Files written whole or not at all: whatever kills the program leaves the old content or the new.

Content goes to `NAME.part` in the same folder, is flushed to the disk, and takes the name's place
by a rename that is flushed too.
"""

import contextlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

PART = ".part"


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a temporary file, which then takes the path's place.

    Raises what `write` raises, and `OSError`; the path keeps what it held before.
    """
    part = path.with_name(path.name + PART)
    try:
        write(part)
        _flush(part)
        part.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        raise
    with contextlib.suppress(OSError):  # not every file system can flush a folder
        _flush(path.parent)


def write_bytes(path: Path, content: bytes) -> None:
    """Write bytes."""
    write_whole(path, lambda part: part.write_bytes(content))


def write_text(path: Path, text: str) -> None:
    """Write text as UTF-8, with the line ends it has."""
    write_bytes(path, text.encode())


def write_json(path: Path, record: Any) -> None:
    """Write indented JSON; numbers that are not finite are refused with `ValueError`."""
    write_text(path, json_text(record) + "\n")


def write_table(path: Path, table: pa.Table) -> None:
    """Write a table as Parquet."""
    write_whole(path, lambda part: pq.write_table(table, part))


def write_picture(path: Path, figure: Any, dpi: float) -> None:
    """Write a matplotlib figure as PNG."""
    write_whole(path, lambda part: figure.savefig(part, dpi=dpi, format="png"))


def json_text(record: Any) -> str:
    """Indented JSON, as in every file and on every page."""
    return json.dumps(record, indent=2, allow_nan=False)


def _flush(path: Path) -> None:
    """Wait until the disk has it."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
