"""Plane task: one operation of a program on one block of planes that are Zarr arrays."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend, Memory
from cnnsim.operations import cellwise
from cnnsim.supersteps.block_task import Place, backend_of
from cnnsim.supersteps.blocks import Blocks, read_cells
from cnnsim.supersteps.store import zarr_library
from cnnsim.workers import one_thread


@dataclass(frozen=True)
class PlaneTask:
    """An operation on one block; it does not write what it reads, so it can run again at any time.

    Arguments: ``verb`` of `VERBS` with its ``arguments``; ``takes``: the arrays that it reads, with ``halo`` cells
    around the block, and the memory they are loaded into; ``gives``: the arrays that it writes.
    """

    blocks: Blocks
    place: Place
    block: int
    halo: int
    verb: str
    arguments: tuple[Any, ...]
    takes: tuple[tuple[Path, Memory], ...]
    gives: tuple[Path, ...]


def run_plane_task(task: PlaneTask) -> Any:
    """Run a task and return the number that its verb gives, or None."""
    zarr = zarr_library()
    rows, cols, ((r0, r1), (c0, c1)) = task.blocks.around(task.block, task.halo)
    (p0, p1), (q0, q1) = task.blocks.area(task.block)
    where, _ = backend_of(task.place)
    with one_thread():
        planes = [
            where.load(read_cells(zarr.open_array(path, mode="r"), rows, cols), memory) for path, memory in task.takes
        ]
        number, found = VERBS[task.verb](where, planes, *task.arguments)
        results = [where.read(plane) for plane in found]
    for path, result in zip(task.gives, results, strict=True):
        zarr.open_array(path, mode="r+")[..., p0:p1, q0:q1] = result[..., r0:r1, c0:c1]
    return number


def _count(where: Backend, planes: list[Any]) -> tuple[Any, tuple[Any, ...]]:
    """Count the black cells, of each grid of a batch."""
    black = where.count(planes[0])
    return black.tolist() if isinstance(black, np.ndarray) else int(black), ()


VERBS: dict[str, Callable[..., tuple[Any, tuple[Any, ...]]]] = {
    "copy": lambda _, planes: (None, (planes[0],)),
    "output": lambda where, planes, f: (None, (where.output(planes[0], f),)),
    "convert": lambda where, planes, memory: (None, (where.convert(planes[0], memory),)),
    "logic": lambda where, planes, function: (None, (where.logic(function, *planes),)),
    "neighbourhood": lambda where, planes, *rule: (None, (where.neighbourhood(*rule, planes[0]),)),
    "cellwise": lambda where, planes, name, *numbers: (None, where.cellwise(cellwise.find(name), planes, numbers)),
    "count": _count,
}
"""Operations of (backend, planes, ...) by name, each giving a number or None and some planes."""
