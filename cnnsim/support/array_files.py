"""NumPy's files of arrays (.npy, .npz) read as plain data: within limits, without pickle, each error in one line."""

import math
import sys
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from cnnsim.support.errors import InputError
from cnnsim.support.limits import check_file, check_unpacked, one_line
from cnnsim.support.memory import check_memory, in_words
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
        with path.open("rb") as file:
            check_head(file, path.stat().st_size, str(path), mapped=True)
        found = np.load(path, mmap_mode="r", allow_pickle=False)
        if not isinstance(found, np.ndarray):
            found.close()
            raise ValueError("several arrays; a single one wanted")
        return found


@contextmanager
def open_npz(path: Path, what: str) -> Iterator["np.lib.npyio.NpzFile"]:
    """Open an NPZ file; ``what`` names its content in messages, such as "texture model".

    Raises:
        InputError: no such file, no NPZ file, one that fails `check_unpacked`, an array larger than
            its file or the memory; also raised for errors inside the block.
    """
    with one_line(path, f"{what} in NPZ"):
        check_file(path, what, sys.maxsize)
        with zipfile.ZipFile(path) as archive:
            check_unpacked(path, sum(member.file_size for member in archive.infolist()))
            for member in archive.infolist():
                with archive.open(member) as head:
                    check_head(head, member.file_size, f"{path}, array {member.filename.removesuffix('.npy')}")
        # opened here: NumPy leaves a file open that is no archive
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            yield file


def read_npz_arrays(path: Path, what: str, names: Iterable[str]) -> dict[str, Array]:
    """Return the arrays of an NPZ file with these names, those that exist.

    Raises:
        InputError: as `open_npz`, or a member that is no array.
    """
    with open_npz(path, what) as file:
        found = {name: file[name] for name in names if name in file.files}
        for name, one in found.items():
            if not isinstance(one, np.ndarray):  # NumPy returns bytes for a member that is no array
                raise ValueError(f"{name} is no array")
    return found


_READERS: dict[tuple[int, int], Callable[..., Any]] = {
    (1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0, (3, 0): npy.read_array_header_2_0,
}  # fmt: skip
"""Readers of headers by version of the format."""


def check_head(file: IO[bytes], there: int, name: str, *, mapped: bool = False) -> None:
    """Check that an array fits into the ``there`` bytes of its file and, unless ``mapped``, into memory.

    ``file`` is at its start; ``name`` is for messages. NumPy reports a broken header when it reads the array.

    Raises:
        InputError: with both sizes.
    """
    try:
        shape, _, dtype = _READERS[npy.read_magic(file)](file)
        pixels = math.prod(int(n) for n in shape)
    except Exception:  # a broken header
        return
    if dtype.hasobject or pixels < 0:
        return
    said, needed = f"{' x '.join(map(str, shape)) or 'one'} of {dtype}", pixels * dtype.itemsize
    left = max(there - file.tell(), 0)
    if needed > left:
        raise InputError(
            f"{name}: {left} bytes of numbers, and its head says {said}, which take {needed} ({in_words(needed)}); a "
            "whole file wanted"
        )
    if not mapped:
        check_memory(f"{name}: reading {said}", needed, "give fewer or smaller arrays")
