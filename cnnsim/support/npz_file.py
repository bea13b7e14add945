"""NPZ files that somebody gives: opened within their bounds, without pickle, every fault of theirs in one line."""

import sys
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from cnnsim.support.bounds import check_file, check_unpacked, one_line


@contextmanager
def open_npz(path: Path, what: str) -> Iterator["np.lib.npyio.NpzFile"]:
    """Open an NPZ file as ``what``, "texture model" for example, and close it after use.

    Raises:
        InputError: no such file, no NPZ file, one that unpacks out of all proportion, or whatever goes wrong inside.
    """
    with one_line(path, f"{what} in NPZ"):
        check_file(path, what, sys.maxsize)
        with zipfile.ZipFile(path) as archive:
            check_unpacked(path, sum(member.file_size for member in archive.infolist()))
        # opened here, since NumPy leaves a file open that turns out to be no archive
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            yield file
