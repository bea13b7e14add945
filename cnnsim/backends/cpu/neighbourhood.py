"""AND and OR of neighbours on packed planes: a shifted row is two shifted words."""

from typing import Any

import numpy as np
from numba import prange

from cnnsim.backends.cpu.bits import last_word
from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.support import Array


@helper
def bit(row: Array, column: int, constant: int) -> Any:
    """Return one cell of a packed row as 0 or 1; column -1 stands for the constant."""
    if column < 0:
        return np.uint64(constant)
    return (row[column // 64] >> np.uint64(column % 64)) & np.uint64(1)


@helper
def widen(row: Array, width: int, cols: Array, r: int, constant: int, wide: Array) -> None:
    """Copy a packed row between a word for the virtual cells on its left and one for those on its right."""
    wide[:] = 0
    for c in range(row.size):
        wide[c + 1] = row[c]
    for v in range(r):
        wide[0] |= bit(row, cols[v], constant) << np.uint64(64 - r + v)
        right = width + v
        wide[1 + right // 64] |= bit(row, cols[r + right], constant) << np.uint64(right % 64)


@twins
def neighbourhood(
    words: Array, out: Array, width: int, k: Array, l: Array, negated: Array, every: bool, rows: Array, cols: Array,
    r: int, constant: int,
) -> None:  # fmt: skip
    """Write, for every cell, whether all (or any) of its listed neighbours are black (or white, where negated).

    ``rows`` and ``cols`` say which real cell a position stands for (-1: the constant).
    """
    n, height, size = words.shape
    wide = np.empty((n, height, size + 2), np.uint64)
    for line in prange(n * height):
        widen(words[line // height, line % height], width, cols, r, constant, wide[line // height, line % height])
    inside, full = last_word(width), ~np.uint64(0)
    for line in prange(n * height):
        g, i = line // height, line % height
        to = out[g, i]
        for c in range(size):
            to[c] = full if every else np.uint64(0)
        for tap in range(k.size):
            p = rows[i + r + k[tap]]
            flip = full if negated[tap] else np.uint64(0)
            outside = full if constant else np.uint64(0)
            # bit j of the result is bit j + l: from this word and the next one (l >= 0), or the one before (l < 0)
            low = np.uint64(l[tap] % 64)
            first = 1 if l[tap] >= 0 else 0
            for c in range(size):
                if p < 0:
                    seen = outside
                elif low == 0:
                    seen = wide[g, p, c + 1]
                else:
                    seen = (wide[g, p, c + first] >> low) | (wide[g, p, c + first + 1] << (np.uint64(64) - low))
                to[c] = to[c] & (seen ^ flip) if every else to[c] | (seen ^ flip)
        to[-1] &= inside
