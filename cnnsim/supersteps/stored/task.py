"""Plane task: one operation of a program on one block of planes that lie on the disk, done on a backend."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend, Memory
from cnnsim.operations import cellwise
from cnnsim.supersteps.block_task import Place, backend_of
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.shards import Shards
from cnnsim.supersteps.store import zarr_library
from cnnsim.support import Array, InputError
from cnnsim.workers.base import one_thread


@dataclass(frozen=True)
class PlaneTask:
    """An operation on a block; it writes what nobody reads meanwhile, so it can be run again at any time.

    Arguments: ``verb`` of `VERBS`, with its ``arguments``; ``takes``: the arrays that it reads, with ``halo`` cells
    around the block, and the memory each is loaded into; ``gives``: the arrays that it writes; ``opened`` tells arrays
    from those that had the same path before.
    """

    blocks: Blocks
    place: Place
    block: int
    halo: int
    verb: str
    arguments: tuple[Any, ...]
    takes: tuple[tuple[Path, Memory], ...]
    gives: tuple[Path, ...]
    opened: str


@lru_cache(64)
def shards_at(path: Path, _opened: str) -> Shards:
    """Return the files of an array by its path."""
    return Shards(zarr_library().open_array(path, mode="r"))


def run_plane_task(task: PlaneTask) -> Any:
    """Run a task, and return the number that the verb gives, if it gives one."""
    (where, _), dtype = backend_of(task.place), np.dtype(task.place.dtype)
    rows, cols, ((r0, r1), (c0, c1)) = task.blocks.around(task.block, task.halo)
    given = [
        shards_at(path, task.opened).cells(rows, cols, np.dtype(bool) if memory == "llm" else dtype)
        for path, memory in task.takes
    ]
    with one_thread():
        planes = [where.load(part, memory, copy=False) for part, (_, memory) in zip(given, task.takes, strict=True)]
        number, found = VERBS[task.verb](where, planes, *task.arguments)
        results = [where.read(plane) for plane in found]
    for path, result in zip(task.gives, results, strict=True):
        shards_at(path, task.opened).write(task.blocks.area(task.block), result[..., r0:r1, c0:c1])
    return number


def _cellwise(where: Backend, planes: list[Any], name: str, *parameters: float) -> tuple[Any, tuple[Any, ...]]:
    return None, where.cellwise(cellwise.find(name), planes, parameters)


def _black(where: Backend, planes: list[Any]) -> tuple[Any, tuple[Any, ...]]:
    """Count the black cells, of each grid of a batch."""
    black = where.count(planes[0])
    return black.tolist() if isinstance(black, np.ndarray) else int(black), ()


def _finite(where: Backend, planes: list[Any]) -> tuple[Any, tuple[Any, ...]]:
    check_finite(where.read(planes[0], copy=False))
    return None, ()


def check_finite(values: Array) -> None:
    """Refuse a part of an input that is not finite.

    Raises:
        InputError: it is not.
    """
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise InputError("an input holds what is not finite; finite numbers wanted")


VERBS: dict[str, Callable[..., tuple[Any, tuple[Any, ...]]]] = {
    "copy": lambda _, planes: (None, (planes[0],)),
    "output": lambda where, planes, f: (None, (where.output(planes[0], f),)),
    "convert": lambda where, planes, memory: (None, (where.convert(planes[0], memory),)),
    "logic": lambda where, planes, function: (None, (where.logic(function, *planes),)),
    "neighbourhood": lambda where, planes, *rule: (None, (where.neighbourhood(*rule, planes[0]),)),
    "cellwise": _cellwise,
    "count": _black,
    "finite": _finite,
}
"""What a task can do with (backend, planes, ...): the verbs of `Backend`, each giving a number and some planes."""
