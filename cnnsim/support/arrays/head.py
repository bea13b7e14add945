"""Heads of NumPy's arrays in files: what shape they say, held against the bytes that there are, before any are read."""

import math
from collections.abc import Callable
from typing import IO, Any

from numpy.lib import format as npy

from cnnsim.support.errors import InputError
from cnnsim.support.memory import check_memory, in_words

_READERS: dict[tuple[int, int], Callable[..., Any]] = {
    (1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0, (3, 0): npy.read_array_header_2_0,
}  # fmt: skip
"""Readers of heads by version; the third has the second's layout."""


def check_head(file: IO[bytes], there: int, name: str, *, mapped: bool = False) -> None:
    """Refuse an array whose head says more than the ``there`` bytes of its file hold, or than the memory does.

    ``file`` is at its begin, ``name`` what messages call it; an array that is ``mapped`` takes no memory. What is no
    head is left for NumPy to refuse.

    Raises:
        InputError: with both sizes, and what to do.
    """
    try:
        shape, _, dtype = _READERS[npy.read_magic(file)](file)
        pixels = math.prod(int(n) for n in shape)
    except Exception:  # whatever goes wrong in a head of a broken file: NumPy says it when it reads the numbers
        return
    if dtype.hasobject or pixels < 0:
        return
    said, needed = f"{' x '.join(map(str, shape)) or 'one'} of {dtype}", pixels * dtype.itemsize
    left = max(there - file.tell(), 0)
    if needed > left:
        raise InputError(
            f"{name}: {left} bytes of numbers, and its head says {said}, which take {needed} ({in_words(needed)}); a "
            "whole file wanted"
        )
    if not mapped:
        check_memory(f"{name}: reading {said}", needed, "give fewer or smaller arrays")
