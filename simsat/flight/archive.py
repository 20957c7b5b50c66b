"""Arrays of a NumPy archive, read with care: nothing is unpacked or allocated before it is known
how large it is, and no pickled object is read."""

import math
import os.path
import zipfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError

HEADER_MAX = 10_000  # bytes of an array's header; NumPy's own are 128


def read_arrays(
    path: Path, names: Iterable[str], size_max: int
) -> tuple[dict[str, Array], list[str]]:
    """Those of the named arrays that the archive holds, and the names of all it holds.

    Raises `SettingsError` if it is no archive, is damaged, or unpacks to more than `size_max`
    bytes.
    """
    if not os.path.isfile(path):
        raise SettingsError(f"no profile at '{path}'")
    try:
        with zipfile.ZipFile(path) as archive:
            held = [name.removesuffix(".npy") for name in archive.namelist()]
            wanted = [archive.getinfo(f"{name}.npy") for name in names if name in held]
            size = sum(info.file_size for info in wanted)
            if size > size_max:
                raise SettingsError(
                    f"profile '{path}' unpacks to {size / 1e6:.0f} MB, more than the "
                    f"{size_max / 1e6:.0f} MB of the longest flight"
                )
            arrays = {info.filename.removesuffix(".npy"): _array(archive, info) for info in wanted}
            return arrays, held
    except SettingsError:
        raise
    except Exception as error:  # zip, zlib and NumPy, which has Python parse an array's header
        raise SettingsError(
            f"profile '{path}' is no NumPy archive; write it with numpy.savez"
        ) from error


def _array(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Array:
    """An array whose header promises no more than the entry holds. Raises `ValueError`."""
    with archive.open(info) as entry:
        version = npy.read_magic(entry)
        header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, dtype = header(entry, max_header_size=HEADER_MAX)
        promised = math.prod(shape) * dtype.itemsize
    if dtype.hasobject or min(shape, default=0) < 0 or promised > info.file_size:
        raise ValueError("objects, or more numbers than there are bytes")
    with archive.open(info) as entry:
        return np.asarray(npy.read_array(entry, allow_pickle=False, max_header_size=HEADER_MAX))
