"""Weights of a neighbourhood: odd square matrices, their checks, and their non-zero entries (taps)."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from cnnsim.support.errors import shown
from cnnsim.support.toml_file import in_range
from cnnsim.support.values import is_number

MAX_RADIUS = 5


class Tap(NamedTuple):
    """A non-zero entry of a template: the ``weight`` of the neighbour at (row + k, col + l)."""

    k: int
    l: int
    weight: float


def checked_weights(owner: str, which: str, entries: ArrayLike, *, varying: bool = False) -> Floats:
    """Return entries as a read-only odd square matrix (side, side); a number is a 1 x 1 matrix.

    With ``varying`` the matrix may be (side, side, rows, cols), with a weight for every cell.

    Raises:
        InputError: not square, of even side, larger than 11 x 11, or an entry that is not finite.
    """
    try:
        matrix = np.array(entries, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        what = _ragged(entries) or shown(entries)
        raise InputError(f"{owner}: {which} is no rectangular matrix of numbers: {what}") from error
    if matrix.ndim == 0:
        matrix = matrix.reshape(1, 1)
    dimensions = (2, 4) if varying else (2,)
    if matrix.ndim not in dimensions or matrix.shape[0] != matrix.shape[1] or matrix.shape[0] % 2 == 0:
        shape = " x ".join(map(str, matrix.shape))
        raise InputError(f"{owner}: {which} is {shape}, an odd square (3 x 3, 5 x 5, ...) wanted")
    if matrix.shape[0] > 2 * MAX_RADIUS + 1:
        raise InputError(f"{owner}: {which} has radius {matrix.shape[0] // 2}, at most {MAX_RADIUS} wanted")
    if not np.isfinite(matrix).all():
        row, col, *_ = where = np.argwhere(~np.isfinite(matrix))[0]
        raise InputError(
            f"{owner}: {which} holds {matrix[tuple(where)]} in row {row + 1}, column {col + 1}; finite numbers wanted"
        )
    matrix.flags.writeable = False
    return matrix


def _ragged(entries: object) -> str:
    """Return a text about the first row whose length differs from row 1; empty if all are equal."""
    if not isinstance(entries, list | tuple) or not all(isinstance(row, list | tuple) for row in entries):
        return ""
    others = [number for number, row in enumerate(entries, start=1) if len(row) != len(entries[0])]
    if not others:
        return ""
    return f"row {others[0]} has {len(entries[others[0] - 1])} entries, row 1 has {len(entries[0])}"


def checked_number(owner: str, which: str, value: object) -> float:
    """Return a finite number.

    Raises:
        InputError: anything else.
    """
    number = value.item() if isinstance(value, np.number) else value
    if not is_number(number) or not in_range(number):
        raise InputError(f"{owner}: {which} is {shown(value)}, a finite number wanted")
    return float(number)


def all_taps(matrix: Floats) -> tuple[Tap, ...]:
    """Return all entries of a matrix as taps, row by row, including zeros."""
    r = matrix.shape[0] // 2
    return tuple(Tap(int(k) - r, int(l) - r, float(matrix[k, l])) for k, l in np.ndindex(matrix.shape))


def taps_of(matrix: Floats) -> tuple[Tap, ...]:
    """Return the non-zero entries, row by row."""
    return tuple(tap for tap in all_taps(matrix) if tap.weight)


def reach(offsets: Iterable[tuple[int, int]]) -> int:
    """Return the largest |k| or |l| of some offsets (k, l)."""
    return max((max(abs(k), abs(l)) for k, l in offsets), default=0)


def matrix_text(matrix: Floats) -> str:
    """Return a matrix on one line; a short text for zeros and for matrices larger than 5 x 5."""
    if not matrix.any():
        return "0"
    if len(matrix) > 5:
        return f"<{len(matrix)} x {len(matrix)}, {np.count_nonzero(matrix)} not zero>"
    rows = [", ".join(f"{value:.4g}" for value in row) for row in matrix]
    return f"[[{'], ['.join(rows)}]]"
