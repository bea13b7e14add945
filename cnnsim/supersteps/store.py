"""Store of a large grid: its planes as Zarr arrays, a shard for each block, and the record of the last superstep.

Each block's state goes by turns between two arrays, so what a superstep reads is never what it writes. The record says
which array has it; it is replaced as a whole after each superstep, so a run that was killed goes on from there.
"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from cnnsim.supersteps.blocks import Area, Blocks, runs
from cnnsim.supersteps.shards import Shards, create
from cnnsim.support import Array, InputError, Integers
from cnnsim.support.extras import install_line
from cnnsim.support.files import make_folder
from cnnsim.support.limits import one_line

Kept = TypeVar("Kept")
FORMAT, VERSION = "cnnsim supersteps", 4
STATES = ("x0", "x1")
STATE, INPUT, MASK = "state", "input", "mask"


@dataclass
class Record:
    """What is known after a superstep: its number, the step, and of each block where its state is and how it moves.

    ``side``: that of the blocks; ``plane``: the array with a block's state; ``upto``: the step that it belongs to,
    earlier than ``step`` where it sleeps; ``saturated``, ``rate``, ``moving``: what the last check of the block found,
    the last where there are cells that are not saturated. ``linked``: planes that are read where they are, and the
    paths there. ``end``: how the run ended.
    """

    side: int
    superstep: int
    step: int
    plane: list[str]
    upto: list[int]
    saturated: list[bool]
    rate: list[float]
    moving: list[Area | None]
    linked: dict[str, str] = field(default_factory=dict)
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


class GridStore:
    """The arrays of one run in a folder, read by regions and written by blocks."""

    def __init__(self, folder: Path, blocks: Blocks) -> None:
        self.folder, self.blocks = folder, blocks
        self._group = zarr_library().open_group(folder, mode="r+")
        self._shards: dict[str, Shards] = {}

    def array(self, name: str) -> Any:
        """Return an array by its name: one of the store, or one that stays where it is (see `Record.linked`)."""
        linked = self._group.attrs.asdict().get("record", {}).get("linked", {})
        return zarr_library().open_array(linked[name], mode="r") if name in linked else self._group[name]

    def shards(self, name: str) -> Shards:
        """Return the files of an array."""
        if name not in self._shards:
            self._shards[name] = Shards(self.array(name))
        return self._shards[name]

    def add(self, name: str, shape: tuple[int, ...], dtype: Any) -> None:
        """Make an array of the grid, an old one of that name gone; truth values take a bit each."""
        create(self._group, name, shape, dtype, self.blocks.side, bits=np.dtype(dtype) == bool)
        self._shards.pop(name, None)

    def read(
        self, plane: str | dict[int, str], rows: Integers, cols: Integers, dtype: Any = None, out: Array | None = None
    ) -> Array:
        """Return the cells in these rows and columns of one array, or of those that have the states of blocks.

        ``dtype``: of what is returned, None for the array's own; ``out``: where they are put, if it is given.
        """
        names = {plane} if isinstance(plane, str) else {plane[block] for block in self.blocks.touched(rows, cols)}
        first, side = self.shards(next(iter(names))), self.blocks.side
        if out is None:
            out = np.empty((*first.shape[:-2], len(rows), len(cols)), first.holds if dtype is None else dtype)
        cut = side if len(names) > 1 else 0
        for (p0, p1), down in runs(rows, cut):
            for (q0, q1), across in runs(cols, cut):
                at = down[0] // side * self.blocks.counts[1] + across[0] // side
                source = self.shards(plane[at]) if isinstance(plane, dict) and cut else first
                source.read(out[..., p0:p1, q0:q1], down, across)
        return out

    def write(self, name: str, area: Area, values: Array) -> None:
        """Write one block: one shard, as it has the block's rows and columns."""
        self.shards(name).write(area, values)

    def whole(self, name: str) -> Array:
        """Return a whole array."""
        return self.read(name, np.arange(self.blocks.shape[0]), np.arange(self.blocks.shape[1]))

    def commit(self, record: Record, run: str) -> None:
        """Replace the record."""
        put_record(self._group, run, asdict(record))


def put_record(group: Any, run: str, record: dict[str, Any], form: str = FORMAT) -> None:
    """Replace the record of a store as a whole; a process that is killed meanwhile leaves the old one or the new."""
    group.attrs.put({"format": form, "version": VERSION, "run": run, "record": record})


def open_store(folder: Path, run: str, form: str = FORMAT) -> dict[str, Any] | None:
    """Open the store of a run in a folder, or make one; return its record, None where there is none yet.

    ``form``: what the store is of, a transient or a program.

    Raises:
        InputError: the folder has something else, another run, or a store of another version; it cannot be made.
    """
    zarr = zarr_library()
    make_folder(folder)
    mark = folder / "zarr.json"
    if not mark.exists():
        if any(folder.iterdir()):
            raise InputError(f"{folder} is not empty, and has no store; a folder of its own wanted")
        zarr.create_group(folder, attributes={"format": form, "version": VERSION, "run": run})
        return None
    with one_line(mark, "the mark of a store"):
        attributes = dict(json.loads(mark.read_text(encoding="utf-8")).get("attributes", {}))
    if attributes.get("format") != form:
        raise InputError(f"{folder} is another Zarr store, not one of {form}; a folder of its own wanted")
    if attributes.get("version") != VERSION:
        raise InputError(f"{folder} is a store of version {attributes.get('version')}; version {VERSION} wanted")
    if attributes.get("run") != run:
        raise InputError(f"{folder} has the store of another run (other numbers or planes); a folder for each wanted")
    kept: dict[str, Any] | None = attributes.get("record")
    return kept


def record_of(folder: Path, kind: Callable[..., Kept], kept: dict[str, Any]) -> Kept:
    """Return the record of a store as a value of its kind.

    Raises:
        InputError: it is none.
    """
    with one_line(folder / "zarr.json", "the record of a run"):
        return kind(**kept)
