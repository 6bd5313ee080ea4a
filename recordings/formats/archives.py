"""Arrays from a NumPy archive that another program, or nobody well-meaning, has written."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.errors import InputError
from models.limits import check_most
from models.regular_files import open_regular

EXPECTED = "a NumPy .npz file"


def read_arrays(path: Path, keys: Iterable[str], where: str) -> dict[str, NDArray[Any]]:
    """Return those of an archive's arrays that it has.

    No object is unpickled, and nothing is allocated that the file does not fill.

    Raises
    ------
    InputError
        If it is no archive, or an array is damaged or larger than `models.limits.LIMITS` allows.
    """
    with open_regular(path, where, EXPECTED, "table_bytes") as file:
        try:
            with zipfile.ZipFile(file) as archive:
                names = {name: f"{name}.npy" for name in keys}
                there = set(archive.namelist())
                return {
                    key: _array(archive, name, f"{where}: key {key}")
                    for key, name in names.items()
                    if name in there
                }
        except InputError:
            raise
        except Exception as error:  # whatever a damaged archive makes of itself
            raise InputError(f"{where}: is no archive of arrays, expected {EXPECTED}") from error


def _array(archive: zipfile.ZipFile, name: str, where: str) -> NDArray[Any]:
    size = archive.getinfo(name).file_size
    check_most("array_bytes", size, where)
    try:
        with archive.open(name) as file:
            version = np.lib.format.read_magic(file)
            read_header = _HEADERS[version]
            shape, _, dtype = read_header(file)
            if dtype.hasobject or math.prod(shape) * dtype.itemsize != size - file.tell():
                raise ValueError("its header does not fit its numbers")
            file.seek(0)
            return np.lib.format.read_array(file, allow_pickle=False)
    except InputError:
        raise
    except Exception as error:  # whatever a damaged archive makes of itself
        raise InputError(f"{where}: {error}, expected an array of numbers") from error


_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
"""Version of an array's header → what reads it."""
