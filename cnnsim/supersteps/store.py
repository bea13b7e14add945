"""Store of a large grid: its planes as Zarr arrays, a shard for each block, and the record of the last superstep.

Each block's state goes by turns between two arrays, so what a superstep reads is never what it writes. The record says
which array has it; it is replaced as a whole after each superstep, so a run that was killed goes on from there.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.supersteps.blocks import Area, Blocks, runs
from cnnsim.support import Array, InputError, Integers
from cnnsim.support.extras import install_line
from cnnsim.support.files import make_folder

FORMAT, VERSION = "cnnsim supersteps", 1
CHUNK = 256
"""The most rows and columns of a chunk in a shard: a halo is read in whole chunks, and each costs some 100 us."""
STATES = ("x0", "x1")
INPUT = "input"


@dataclass
class Record:
    """What is known after a superstep: its number, the step, and of each block where its state is and how it moves.

    ``plane``: the array with a block's state; ``upto``: the step that it belongs to, earlier than ``step`` where it
    sleeps; ``saturated``, ``rate``: what the last check of the block found. ``end``: how the run ended.
    """

    superstep: int
    step: int
    plane: list[str]
    upto: list[int]
    saturated: list[bool]
    rate: list[float]
    checked: bool = False
    end: dict[str, Any] | None = None


def zarr_library() -> Any:
    """Return zarr.

    Raises:
        InputError: it is missing.
    """
    try:
        import zarr  # slow to import, and only large grids need it
    except ImportError as error:
        raise InputError(f"large grids lie in Zarr stores, and zarr is missing: {install_line('scale')}") from error
    return zarr


def chunk_of(side: int) -> int:
    """Return the side of a chunk: the largest part of a block's up to `CHUNK`, if there is one that is not tiny."""
    part = next(size for size in range(min(side, CHUNK), 0, -1) if side % size == 0)
    return part if part >= min(side, CHUNK // 4) else side


class GridStore:
    """The arrays of one run in a folder, read by regions and written by blocks."""

    def __init__(self, folder: Path, blocks: Blocks) -> None:
        self.folder, self.blocks = folder, blocks
        zarr = zarr_library()
        self._group = zarr.open_group(folder, mode="r+")
        self._arrays: dict[str, Any] = {}

    def array(self, name: str) -> Any:
        """Return an array by its name."""
        if name not in self._arrays:
            self._arrays[name] = self._group[name]
        return self._arrays[name]

    def has(self, name: str) -> bool:
        """Return whether there is an array of that name."""
        return name in self._group

    def add(self, name: str, shape: tuple[int, ...], dtype: Any, *, packed: bool) -> None:
        """Make an array of the grid, an old one of that name gone; ``packed``: compressed, as it is written once."""
        side, lead = self.blocks.side, shape[:-2]
        more: dict[str, Any] = {} if packed else {"compressors": None}
        part = chunk_of(side)
        self._arrays[name] = self._group.create_array(
            name, shape=shape, dtype=dtype, shards=(*lead, side, side), chunks=(*lead, part, part), filters=None,
            fill_value=0, overwrite=True, **more,
        )  # fmt: skip

    def read(self, plane: str | dict[int, str], rows: Integers, cols: Integers) -> Array:
        """Return the cells in these rows and columns of one array, or of those that have the states of blocks."""
        names = {plane} if isinstance(plane, str) else {plane[block] for block in self.blocks.touched(rows, cols)}
        first = self.array(next(iter(names)))
        out = np.empty((*first.shape[:-2], len(rows), len(cols)), first.dtype)
        side = self.blocks.side if len(names) > 1 else 0
        for (p0, p1), (r0, r1) in runs(rows, side):
            for (q0, q1), (c0, c1) in runs(cols, side):
                at = r0 // self.blocks.side * self.blocks.counts[1] + c0 // self.blocks.side
                source = self.array(plane[at] if isinstance(plane, dict) and side else next(iter(names)))
                out[..., p0:p1, q0:q1] = source[..., r0:r1, c0:c1]
        return out

    def write(self, name: str, area: Area, values: Array) -> None:
        """Write one block: one shard, as it has the block's rows and columns."""
        (r0, r1), (c0, c1) = area
        self.array(name)[..., r0:r1, c0:c1] = values

    def commit(self, record: Record, run: str) -> None:
        """Replace the record."""
        self._group.attrs.put({"format": FORMAT, "version": VERSION, "run": run, "record": asdict(record)})


def open_store(folder: Path, blocks: Blocks, run: str) -> tuple[GridStore, Record | None]:
    """Open the store of a run in a folder, or make one; the record is None where the planes are still to be written.

    Raises:
        InputError: the folder has something else, another run, or a store of another version; it cannot be made.
    """
    zarr = zarr_library()
    make_folder(folder)
    mark = folder / "zarr.json"
    if not mark.exists():
        if any(folder.iterdir()):
            raise InputError(f"{folder} is not empty, and has no store; a folder of its own wanted")
        zarr.create_group(folder, attributes={"format": FORMAT, "version": VERSION, "run": run})
        return GridStore(folder, blocks), None
    try:
        attributes = json.loads(mark.read_text(encoding="utf-8")).get("attributes", {})
    except (OSError, ValueError) as error:
        raise InputError(f"{mark} cannot be read: {error}") from error
    if attributes.get("format") != FORMAT:
        raise InputError(f"{folder} is another Zarr store; a folder of its own wanted")
    if attributes.get("version") != VERSION:
        raise InputError(f"{folder} is a store of version {attributes.get('version')}; version {VERSION} wanted")
    if attributes.get("run") != run:
        raise InputError(f"{folder} has the store of another run (other numbers or planes); a folder for each wanted")
    kept = attributes.get("record")
    return GridStore(folder, blocks), None if kept is None else Record(**kept)
