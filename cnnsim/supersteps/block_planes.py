"""Planes of a block with its halo, read from a store into the memory where the last block had its own."""

import math
from threading import local
from typing import Any

import numpy as np

from cnnsim.supersteps.store import INPUT, MASK, STATE, GridStore
from cnnsim.support import Array, Integers

ROOMY = 1.5
"""A plane may lie in memory that is so many times larger: blocks at an edge are smaller than others by their halo."""


class _Memory(local):
    """The memory of a thread's planes: what the system hands out anew takes as long as steps of the time loop."""

    def __init__(self) -> None:
        self._kept: dict[str, Array] = {}

    def plane(self, name: str, shape: tuple[int, ...], dtype: np.dtype[Any]) -> Array:
        """Return a plane with anything in it; the one of that name before it is in use no more."""
        size, kept = math.prod(shape), self._kept.pop(name, None)
        if kept is None or kept.dtype != dtype or not size <= kept.size <= ROOMY * size:
            kept = None  # gone before the next is there
            kept = np.empty(size, dtype)
        self._kept[name] = kept
        return kept[:size].reshape(shape)


_MEMORY = _Memory()


def read_planes(
    store: GridStore, planes: dict[int, str], given: tuple[str, ...], cells: tuple[Integers, Integers],
    dtype: np.dtype[Any],
) -> tuple[Array, dict[str, Array]]:  # fmt: skip
    """Return the state, and what is ``given`` besides it, of the cells in these rows and columns.

    ``planes``: the arrays with the states of blocks. What is returned stands until the thread reads the next block. A
    picture that is state and input is read once.
    """

    def read(name: str, plane: str | dict[int, str], of: np.dtype[Any]) -> Array:
        lead = store.shards(plane if isinstance(plane, str) else next(iter(arrays))).shape[:-2]
        return store.read(plane, *cells, of, _MEMORY.plane(name, (*lead, *map(len, cells)), of))

    arrays = set(planes.values())
    found = {name: read(name, name, np.dtype(bool) if name == MASK else dtype) for name in given}
    if arrays == {INPUT}:
        return found[INPUT], found
    return read(STATE, planes, dtype), found
