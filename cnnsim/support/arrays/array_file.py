"""NumPy's files of one array (.npy) read as plain data, within bounds; nothing in them is run."""

import sys
from pathlib import Path

import numpy as np

from cnnsim.support.arrays.head import check_head
from cnnsim.support.bounds import check_file, one_line
from cnnsim.support.errors import InputError
from cnnsim.support.memory import check_memory
from cnnsim.support.types import Array


def read_array(path: Path, what: str = "an array of NumPy") -> Array:
    """Return the array of an .npy file.

    Raises:
        InputError: no such file, no array, a shape that the file is too short for, no real numbers.
    """
    mapped = mapped_array(path, what)
    check_memory(f"{path}: reading {mapped.nbytes} bytes", mapped.nbytes, "give a smaller array")
    found = np.array(mapped)
    if found.dtype.kind not in "biuf":
        raise InputError(f"{path} holds {found.dtype}; real numbers wanted")
    return found


def mapped_array(path: Path, what: str = "an array of NumPy") -> Array:
    """Return the array of an .npy file as it lies there, read where it is looked at.

    Raises:
        InputError: as `read_array`.
    """
    with one_line(path, what):
        check_file(path, what.partition(" ")[2], sys.maxsize)
        with path.open("rb") as file:
            check_head(file, path.stat().st_size, str(path), mapped=True)
        found = np.load(path, mmap_mode="r", allow_pickle=False)
        if not isinstance(found, np.ndarray):
            found.close()
            raise ValueError("several arrays; a single one wanted")
        return found
