"""Black-and-white planes of the CPU backend, 64 cells a word: packing, logic and counts."""

import math
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import prange, types
from numba.extending import intrinsic

from cnnsim.backends.cpu.compiled import helper, twins
from cnnsim.support import Array


class Bits(NamedTuple):
    """An LLM plane: ``words`` (n, rows, ceil(cols / 64)) of uint64, bit b of word c is column 64 c + b, black is 1.

    ``shape`` is that of the plane: (rows, cols) or (n, rows, cols). Bits beyond the last column are 0.
    """

    words: Array
    shape: tuple[int, ...]


def empty(shape: tuple[int, ...]) -> Bits:
    """Return a plane with any contents."""
    return Bits(np.empty((math.prod(shape[:-2]), shape[-2], -(-shape[-1] // 64)), np.uint64), shape)


@helper
def last_word(cols: int) -> Any:
    """Return the mask of the bits of a row's last word that are cells."""
    return ~np.uint64(0) >> np.uint64((64 - cols % 64) % 64)


@intrinsic  # type: ignore[untyped-decorator]
def word_of(_typing: Any, row: Array, first: int) -> Any:
    """Return the word of 64 values of a row from ``first``, by one comparison of vectors.

    LLVM shifts every bit of a loop over bits on its own, which takes two to ten times as long.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind, begin = (
            signature.args[0].dtype,
            context.make_array(signature.args[0])(context, builder, arguments[0]).data,
        )
        values = ir.VectorType(context.get_data_type(kind), 64)
        at = builder.bitcast(builder.gep(begin, [arguments[1]]), values.as_pointer())
        value, zero = (
            builder.load(at, align=context.get_abi_sizeof(context.get_data_type(kind))),
            ir.Constant(values, None),
        )
        if isinstance(kind, types.Float):
            black = builder.fcmp_ordered(">", value, zero)
        elif kind in types.signed_domain:
            black = builder.icmp_signed(">", value, zero)
        else:  # and truth values
            black = builder.icmp_unsigned(">", value, zero)
        return builder.bitcast(black, ir.IntType(64))

    return types.uint64(row, first), code


@twins
def pack(values: Array, words: Array) -> None:
    """Set a bit for every value above 0."""
    height, width = values.shape[1:]
    whole = width // 64
    for line in prange(words.shape[0] * height):
        row, to = values[line // height, line % height], words[line // height, line % height]
        for c in range(whole):
            to[c] = word_of(row, 64 * c)
        if whole < to.size:
            word, part = np.uint64(0), row[64 * whole :]
            for b in range(part.size):
                word |= np.uint64(part[b] > 0) << np.uint64(b)
            to[whole] = word


@twins
def unpack(words: Array, values: Array, black: Any, white: Any) -> None:
    """Write ``black`` or ``white`` for every bit."""
    height, width = values.shape[1:]
    for line in prange(words.shape[0] * height):
        row, to = words[line // height, line % height], values[line // height, line % height]
        for c in range(row.size):
            word = row[c]
            part = to[64 * c : min(64 * c + 64, width)]
            for b in range(part.size):
                part[b] = black if (word >> np.uint64(b)) & np.uint64(1) else white


@twins
def logic(function: int, p: Array, q: Array, out: Array, cols: int) -> None:
    """Apply the function whose truth table is the number's bits (see `cnnsim.operations.logic`)."""
    zero = np.uint64(0)
    m0, m1 = (~zero if function & 1 else zero), (~zero if function & 2 else zero)
    m2, m3 = (~zero if function & 4 else zero), (~zero if function & 8 else zero)
    height, inside = p.shape[1], last_word(cols)
    for line in prange(p.shape[0] * height):
        a, b = p[line // height, line % height], q[line // height, line % height]
        to = out[line // height, line % height]
        for c in range(to.size):
            to[c] = (a[c] & ((b[c] & m3) | (~b[c] & m2))) | (~a[c] & ((b[c] & m1) | (~b[c] & m0)))
        to[-1] &= inside


@helper
def add_up(lines: Array, height: int, totals: Array) -> None:
    """Add the counts of the lines of every grid; a helper, because numba would start the threads for each sum."""
    for g in range(totals.size):
        totals[g] = 0
        for i in range(height):
            totals[g] += lines[g * height + i]


@twins
def count(words: Array, totals: Array) -> None:
    """Count the black cells of every grid: bits are added in pairs, fours, eights, and the eight bytes at once."""
    height = words.shape[1]
    lines = np.empty(words.shape[0] * height, np.int64)
    pairs, fours, eights = np.uint64(0x5555555555555555), np.uint64(0x3333333333333333), np.uint64(0x0F0F0F0F0F0F0F0F)
    ones = np.uint64(0x0101010101010101)
    for line in prange(lines.size):
        row = words[line // height, line % height]
        total = np.uint64(0)
        for c in range(row.size):
            v = row[c]
            v -= (v >> np.uint64(1)) & pairs
            v = (v & fours) + ((v >> np.uint64(2)) & fours)
            v = (v + (v >> np.uint64(4))) & eights
            total += (v * ones) >> np.uint64(56)
        lines[line] = total
    add_up(lines, height, totals)
