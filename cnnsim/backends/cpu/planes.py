"""Loops over planes (n, rows, cols): the output, and whether all cells are finite.

They are plain loops, because numba takes up to two seconds to compile a NumPy function.
"""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.compiled import helper, twins
from cnnsim.support import Array


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
def clip_row(row: Array, out: Array) -> None:
    """Write clip(row, -1, 1); NaN stays NaN."""
    one = row.dtype.type(1)
    for j in range(row.size):
        v = row[j]
        v = one if v > one else v
        out[j] = -one if v < -one else v


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
        clip_row(x[line // x.shape[1], line % x.shape[1]], out[line // x.shape[1], line % x.shape[1]])
