"""The local logic unit: the 16 functions of two black-and-white planes, by name and by truth table."""

import numpy as np

from cnnsim.support import Flags
from cnnsim.support.errors import not_known

FUNCTIONS = (
    "white",         # nothing is black
    "nor",
    "not-p-and-q",
    "not-p",
    "p-and-not-q",
    "not-q",
    "xor",
    "nand",
    "and",
    "equal",
    "q",
    "not-p-or-q",
    "p",
    "p-or-not-q",
    "or",
    "black",
)  # fmt: skip
"""Names in the order of their truth tables: bit 2p + q of the index is the result for (p, q)."""


def function_number(name: str) -> int:
    """Return the index of a function in `FUNCTIONS`.

    Raises:
        InputError: no function has the name.
    """
    if name not in FUNCTIONS:
        raise not_known("logic function", name, FUNCTIONS)
    return FUNCTIONS.index(name)


def truth_table(function: int) -> Flags:
    """Return the results for (p, q) = (0, 0), (0, 1), (1, 0), (1, 1)."""
    return np.array([function >> i & 1 for i in range(4)], dtype=bool)
