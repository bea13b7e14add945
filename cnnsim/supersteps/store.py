"""Store of a large grid: a Zarr group with its planes in chunks, and the record of the progress.

The record is an attribute of the group, which Zarr replaces as a whole, so a run that is killed resumes from it.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.supersteps.blocks import Blocks
from cnnsim.support import Array, InputError
from cnnsim.support.extras import install_line
from cnnsim.support.files import make_folder
from cnnsim.support.limits import one_line
from cnnsim.support.progress import watcher

VERSION = 5
CHUNK, SMALLEST_CHUNK = 512, 64
"""Sides of a chunk [cells]: the largest, and the smallest of which several are in a block."""


def zarr_library() -> Any:
    """Return the zarr library.

    Raises:
        InputError: it is missing.
    """
    try:
        import zarr  # slow to import
    except ImportError as error:
        raise InputError(f"large grids need zarr, which is missing: {install_line('scale')}") from error
    return zarr


class GridStore:
    """The Zarr group in a folder, of one run; ``kind`` is what it is a store of.

    Raises:
        InputError: the folder has other files, another run, or a store of another kind or version.
    """

    def __init__(self, folder: Path, run: str, kind: str) -> None:
        self.folder, self._attributes = folder, {"format": kind, "version": VERSION, "run": run}
        zarr, mark = zarr_library(), folder / "zarr.json"
        make_folder(folder)
        if not mark.exists():
            if any(folder.iterdir()):
                raise InputError(f"{folder} is not empty and has no store; an empty folder wanted")
            self._group = zarr.create_group(folder, attributes=self._attributes)
            self.record: dict[str, Any] | None = None
            return
        with one_line(mark, "a Zarr group"):
            found = dict(json.loads(mark.read_text(encoding="utf-8")).get("attributes", {}))
        if found.get("format") != kind:
            raise InputError(f"{folder} is another Zarr store, not one of {kind}; an empty folder wanted")
        if found.get("version") != VERSION:
            raise InputError(f"{folder} is a store of version {found.get('version')}; version {VERSION} wanted")
        if found.get("run") != run:
            raise InputError(
                f"{folder} has the store of another run (other numbers or planes); a folder for each wanted"
            )
        with one_line(mark, "the record of a run"):
            self._group = zarr.open_group(folder, mode="r+")
        self.record = found.get("record")

    def commit(self, record: dict[str, Any]) -> None:
        """Replace the record as a whole."""
        self.record = record
        self._group.attrs.put({**self._attributes, "record": record})

    def create(self, name: str, shape: tuple[int, ...], dtype: Any, side: int, fill: float = 0) -> Any:
        """Create an array whose chunks divide blocks of ``side`` cells; only booleans are compressed."""
        part = next(cells for cells in range(min(side, CHUNK), 0, -1) if side % cells == 0)
        chunk = side if part < SMALLEST_CHUNK else part
        compressors = "auto" if np.dtype(dtype) == bool else None
        return self._group.create_array(
            name, shape=shape, chunks=(*shape[:-2], chunk, chunk), dtype=dtype, compressors=compressors,
            fill_value=fill, overwrite=True,
        )  # fmt: skip

    def write_plane(
        self, name: str, plane: Any, shape: tuple[int, ...], dtype: np.dtype[Any], blocks: Blocks, *, logic: bool
    ) -> None:
        """Write a plane block by block: ``logic`` as whether it is above 0, else as numbers; booleans become +1, -1.

        Raises:
            InputError: values that are not finite.
        """
        array = self.create(name, shape, bool if logic else dtype, blocks.side)
        for block in range(len(blocks)):
            (r0, r1), (c0, c1) = blocks.area(block)
            values = plane_values(plane[..., r0:r1, c0:c1], dtype, logic=logic, name=name)
            array[..., r0:r1, c0:c1] = np.broadcast_to(values, (*shape[:-2], *values.shape[-2:]))
            if (report := watcher()) is not None:
                report((block + 1) / len(blocks), f"{name} to {self.folder}")


def plane_values(part: Any, dtype: np.dtype[Any], *, logic: bool, name: str) -> Array:
    """Return a part of a plane as it is stored, see `GridStore.write_plane`."""
    values = np.asarray(part)
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise InputError(f"{name} holds values that are not finite; finite numbers wanted")
    if logic:
        return values > 0
    return np.where(values, 1, -1).astype(dtype) if values.dtype == bool else values.astype(dtype, copy=False)
