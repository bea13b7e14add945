"""Identity of a plane: what tells it from the one that a store was begun with, before its run goes on."""

import os
import zlib
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.supersteps.pictures import TiledPicture

STRIP = 1024
"""Rows of a plane that are read at a time for its checksum, whatever the blocks are."""
READ = 1 << 28
"""Bytes of a Zarr array's files up to which they are read, in a quarter of a second; larger ones are told by their
sizes and times: one that was written again as it was is then taken for another one."""
_PIECE = 1 << 20


def identity(plane: Any) -> bytes:
    """Return what tells a plane from others: its contents; of a Zarr array on the disk where it is, too.

    A run may read such an array where it is, by its path, so one that was moved or copied belongs to another run.
    """
    if hasattr(plane, "store_path") and hasattr(plane.store, "root"):
        return _of_files((Path(plane.store.root) / plane.path).absolute())
    if isinstance(plane, TiledPicture) and (told := plane.told()) is not None:
        return told
    total = 0
    for r0 in range(0, plane.shape[-2], STRIP):
        total = zlib.crc32(np.ascontiguousarray(plane[..., r0 : r0 + STRIP, :]).data.cast("B"), total)
    return repr((plane.shape, np.dtype(plane.dtype).str, total)).encode()


def _of_files(folder: Path) -> bytes:
    told, files = sha256(bytes(folder)), list(_files(folder))
    small = sum(entry.stat().st_size for entry in files) <= READ
    for entry in files:
        told.update(os.fsencode(entry.path) + b"\0")
        if small or entry.name == "zarr.json":
            with Path(entry.path).open("rb") as file:
                while piece := file.read(_PIECE):
                    told.update(piece)
        else:
            about = entry.stat()
            told.update(repr((about.st_size, about.st_mtime_ns)).encode())
    return told.digest()


def _files(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Yield the files in a folder and its folders, always in one order."""
    with os.scandir(folder) as found:
        for entry in sorted(found, key=lambda one: one.name):
            if entry.is_dir():
                yield from _files(Path(entry.path))
            else:
                yield entry
