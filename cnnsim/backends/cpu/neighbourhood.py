"""AND and OR of neighbours on packed planes, 64 cells at a time."""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.bits import last_word
from cnnsim.backends.cpu.boundary import VirtualCells, packed_cell, real_row
from cnnsim.backends.cpu.compiled import helper, twins
from cnnsim.operations.bitwise import BitRule
from cnnsim.support import Array

LITERAL = np.dtype([("k", np.int64), ("l", np.int64), ("negated", np.bool_)], align=True)


def literals(rule: BitRule) -> Array:
    """Return a rule's literals as records."""
    return np.array(list(rule.literals), LITERAL)


@helper
def widen(grid: Array, i: int, width: int, virtual: VirtualCells, wide: Array) -> None:
    """Copy row i of a packed grid between a word for the virtual cells on its left and one for those on its right."""
    p, r = real_row(i, virtual), virtual[2]
    wide[:] = 0
    if p >= 0:
        for c in range(grid.shape[1]):
            wide[c + 1] = grid[p, c]
    else:
        for j in range(width):
            wide[1 + j // 64] |= packed_cell(grid, i, j, virtual) << np.uint64(j % 64)
    for v in range(r):
        wide[0] |= packed_cell(grid, i, v - r, virtual) << np.uint64(64 - r + v)
        right = width + v
        wide[1 + right // 64] |= packed_cell(grid, i, right, virtual) << np.uint64(right % 64)


@twins
def neighbourhood(
    words: Array, out: Array, width: int, literals: Array, conjunction: bool, virtual: VirtualCells
) -> None:
    """Write, for every cell, whether all (or any) of its listed neighbours are black (or white, where negated)."""
    n, height, size = words.shape
    r = virtual[2]
    tall = height + 2 * r
    wide = np.empty((n, tall, size + 2), np.uint64)
    for line in prange(n * tall):
        widen(words[line // tall], line % tall - r, width, virtual, wide[line // tall, line % tall])
    inside, full = last_word(width), ~np.uint64(0)
    for line in prange(n * height):
        g, i = line // height, line % height
        to = out[g, i]
        for c in range(size):
            to[c] = full if conjunction else np.uint64(0)
        for tap in range(literals.size):
            row, l = wide[g, i + r + literals[tap]["k"]], literals[tap]["l"]
            flip = full if literals[tap]["negated"] else np.uint64(0)
            # bit j of the result is bit j + l: from this word and the next one (l >= 0), or the one before (l < 0)
            low = np.uint64(l % 64)
            first = 1 if l >= 0 else 0
            for c in range(size):
                value = row[c + 1]
                if low > 0:
                    value = (row[c + first] >> low) | (row[c + first + 1] << (np.uint64(64) - low))
                to[c] = to[c] & (value ^ flip) if conjunction else to[c] | (value ^ flip)
        to[-1] &= inside
