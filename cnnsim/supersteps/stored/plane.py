"""Stored plane: a plane of a program as an array on the disk, which goes when nobody holds it any more."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple
from weakref import finalize

from cnnsim.backends.base import Memory


class PlaneFiles:
    """A Zarr array of a store; ``dropped`` takes the folder that may be deleted once nobody holds it."""

    def __init__(self, path: Path, shape: tuple[int, ...], dropped: Callable[[Path], None], folder: Path) -> None:
        self.path, self.shape = path, shape
        finalize(self, dropped, folder).atexit = False  # a program that is stopped goes on with its planes


class StoredPlane(NamedTuple):
    """A plane and the memory that it is in; black and white that is read as a LAM plane stays the bits it is."""

    files: PlaneFiles
    memory: Memory

    @property
    def shape(self) -> tuple[int, ...]:
        """(rows, cols), or (n, rows, cols)."""
        return self.files.shape
