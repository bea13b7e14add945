"""NumPy's files of arrays (.npy, .npz) read as plain data: within limits, without pickle, each error in one line."""

import sys
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from cnnsim.support.errors import InputError
from cnnsim.support.limits import check_file, check_unpacked, one_line
from cnnsim.support.memory import check_memory
from cnnsim.support.values import Array


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
    """Return the array of an .npy file, mapped into memory.

    Raises:
        InputError: as `read_array`.
    """
    with one_line(path, what):
        check_file(path, what.partition(" ")[2], sys.maxsize)
        found = np.load(path, mmap_mode="r", allow_pickle=False)
        if not isinstance(found, np.ndarray):
            found.close()
            raise ValueError("several arrays; a single one wanted")
        return found


@contextmanager
def open_npz(path: Path, what: str) -> Iterator["np.lib.npyio.NpzFile"]:
    """Open an NPZ file; ``what`` names its content in messages, such as "texture model".

    Raises:
        InputError: no such file, no NPZ file, one that fails `check_unpacked`, more than the memory; also
            raised for errors inside the block.
    """
    with one_line(path, f"{what} in NPZ"):
        check_file(path, what, sys.maxsize)
        with zipfile.ZipFile(path) as archive:
            size = sum(member.file_size for member in archive.infolist())
            check_unpacked(path, size)
            check_memory(f"{path}: reading {size} bytes", size, "give fewer or smaller arrays")
        # opened here: NumPy leaves a file open that is no archive
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            yield file


def read_npz_arrays(path: Path, what: str, names: Iterable[str]) -> dict[str, Array]:
    """Return the arrays of an NPZ file that have these names.

    Raises:
        InputError: as `open_npz`, or a member that is no array.
    """
    with open_npz(path, what) as file:
        found = {name: file[name] for name in names if name in file.files}
        for name, one in found.items():
            if not isinstance(one, np.ndarray):  # NumPy returns bytes for a member that is no array
                raise ValueError(f"{name} is no array")
    return found
