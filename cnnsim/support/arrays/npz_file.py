"""NPZ files that somebody gives: opened within their bounds, without pickle, every fault of theirs in one line."""

import sys
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from cnnsim.support.arrays.head import check_head
from cnnsim.support.bounds import check_file, check_unpacked, one_line
from cnnsim.support.types import Array


@contextmanager
def open_npz(path: Path, what: str) -> Iterator["np.lib.npyio.NpzFile"]:
    """Open an NPZ file as ``what``, "texture model" for example, and close it after use.

    Raises:
        InputError: no such file, no NPZ file, one that unpacks out of all proportion, an array larger than its file or
            the memory, or whatever goes wrong inside.
    """
    with one_line(path, f"{what} in NPZ"):
        check_file(path, what, sys.maxsize)
        with zipfile.ZipFile(path) as archive:
            check_unpacked(path, sum(member.file_size for member in archive.infolist()))
            for member in archive.infolist():
                with archive.open(member) as head:
                    check_head(head, member.file_size, f"{path}, array {member.filename.removesuffix('.npy')}")
        # opened here, since NumPy leaves a file open that turns out to be no archive
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            yield file


def read_npz_arrays(path: Path, what: str, names: Iterable[str]) -> dict[str, Array]:
    """Return those arrays of an NPZ file that are there, by name.

    Raises:
        InputError: as `open_npz`, or a member that is no array.
    """
    with open_npz(path, what) as file:
        found = {name: file[name] for name in names if name in file.files}
        for name, one in found.items():
            if not isinstance(one, np.ndarray):  # NumPy gives out bytes of what does not begin as an array
                raise ValueError(f"{name} is no array")
    return found
