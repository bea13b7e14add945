"""Dictionary of the 65 536 sign codes of two 2 x 2 fingers, in words; larger arrays reduce to them by votes."""

from collections.abc import Iterator
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tactile.events.code import Code
from tactile.events.hand import OPPOSITE

CODES = 1 << 16
"""Two bits a taxel, eight a finger, two fingers."""
X = np.array([[-1, 1], [-1, 1]])
"""x positions of the taxels of a 2 x 2 finger; the transpose has the y positions (down)."""


@cache  # a finger has 256 of them, the whole dictionary asks 131 072 times
def finger_word(code: int) -> str:
    """Return the meaning of the eight bits of a finger: the motion that most of its signs agree with.

    With signs (sx, sy) of the taxels at (x, y): pull sum s, turn sum (x sy - y sx), spread sum (x sx + y sy). A turn or
    spread needs six of the eight signs, a pull along an axis three of four.
    """
    bits = np.array([1 if code >> (7 - n) & 1 else -1 for n in range(8)]).reshape(2, 2, 2)
    sx, sy = bits[..., 0], bits[..., 1]
    turn, spread = int((X * sy - X.T * sx).sum()), int((X * sx + X.T * sy).sum())
    if abs(turn) >= 4 and abs(turn) > abs(spread):
        return "twist clockwise" if turn > 0 else "twist anticlockwise"
    if abs(spread) >= 4 and abs(spread) > abs(turn):
        return "spread" if spread > 0 else "pinch"
    sums = ((int(sx.sum()), "x"), (int(sy.sum()), "y"))
    along = " ".join(f"{'+' if total > 0 else '-'}{axis}" for total, axis in sums if abs(total) >= 2)
    return f"pull {along}" if along else "about a point"


def word(code: int) -> str:
    """Return the meaning of a code of 16 bits, first finger highest; of the hand if both fingers agree or oppose."""
    first, second = finger_word(code >> 8), finger_word(code & 0xFF)
    if first == second:
        return "lift" if first == "pull +y" else f"both {first}"
    one, other = first.removeprefix("pull "), second.removeprefix("pull ")
    if OPPOSITE.get(one) == other:
        return f"twist of the fingers against each other, {one} and {other}"
    return f"{first}; {second}"


def entries() -> Iterator[tuple[int, str]]:
    """Return every code with its meaning."""
    return ((code, word(code)) for code in range(CODES))


def reduced(code: Code) -> int:
    """Return the eight bits of a finger of any size: each quarter of its taxels votes on both signs; a tie is minus."""
    bits = [
        vote(quarter) for rows in _halves(code.x.shape[0]) for cols in _halves(code.x.shape[1])
        for quarter in (code.x[rows, cols], code.y[rows, cols])
    ]  # fmt: skip
    return int("".join("01"[bit] for bit in bits), 2)


def vote(signs: NDArray[np.int8]) -> bool:
    """Whether more taxels are plus than minus."""
    return int(signs.sum(dtype=np.int64)) > 0


def _halves(count: int) -> tuple[slice, slice]:
    """Return both halves of an axis; both include the middle of an odd length."""
    return slice(0, (count + 1) // 2), slice(count // 2, count)
