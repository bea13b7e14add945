"""Planes (n, rows, cols): the output, whether all cells are finite, and memory for the next transient.

Loops are plain loops, because numba takes up to two seconds to compile a NumPy function.
"""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.compiled import helper, twins
from cnnsim.backends.cpu.tiles.functions import clip_row
from cnnsim.support import Array

MOST = 3
"""Planes kept: the drive of a transient, and the two planes between which its steps alternate."""
WORTH_KEEPING = 1 << 20
"""Bytes of a plane from which fresh memory of the system costs more than a step of the time loop."""


def grids(plane: Array) -> Array:
    """Return a view of planes as a batch (n, rows, cols); layers are grids of it."""
    return plane if plane.ndim == 3 else plane.reshape(-1, *plane.shape[-2:])


@helper
def all_true(values: Array) -> bool:
    """Return whether all are true."""
    count = 0
    for value in values:
        count += value
    return count == values.size


@helper
def finite_row(row: Array) -> bool:
    """Return whether no value is NaN or infinite: x * 0 is 0 exactly for finite x."""
    zero = row.dtype.type(0)
    fine = True
    for j in range(row.size):
        fine &= row[j] * zero == zero  # vector code, which a sum in order is not
    return fine


@twins
def all_finite(x: Array) -> bool:
    """Return whether no value is NaN or infinite."""
    n = x.shape[0] * x.shape[1]
    fine = np.empty(n, np.bool_)
    for line in prange(n):
        fine[line] = finite_row(x[line // x.shape[1], line % x.shape[1]])
    return all_true(fine)


@twins
def clip(x: Array, out: Array) -> None:
    """Write the output characteristic of x."""
    for line in prange(x.shape[0] * x.shape[1]):
        row = x[line // x.shape[1], line % x.shape[1]]
        clip_row(out[line // x.shape[1], line % x.shape[1]], row, row.dtype.type(1))


class Pool:
    """At most `MOST` large planes that are free."""

    def __init__(self) -> None:
        self._kept: list[Array] = []

    def plane(self, like: Array) -> Array:
        """Return a plane of the shape and type of another one, with any contents."""
        while self._kept and like.nbytes >= WORTH_KEEPING:
            plane = self._kept.pop()
            if plane.dtype == like.dtype and plane.size == like.size:
                return plane.reshape(like.shape)
        return np.empty_like(like)

    def keep(self, *planes: Array) -> None:
        """Take planes that are free."""
        self._kept += [plane for plane in planes if plane.nbytes >= WORTH_KEEPING]
        del self._kept[:-MOST]
