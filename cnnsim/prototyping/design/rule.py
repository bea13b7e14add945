"""Window rule: the answer to all black-and-white 3 x 3 windows (and initial states): black, white, or either."""

from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cnnsim.network import Boundary, pad
from cnnsim.support import Floats, InputError, Integers
from cnnsim.support.values import as_numbers

NAMES = ("nw", "n", "ne", "w", "c", "e", "sw", "s", "se", "x")
"""The cells of a window, row by row; ``x`` is the cell's own initial state."""

Signs = NDArray[np.int8]
"""Cells as -1 and +1."""


@dataclass(frozen=True, eq=False)
class WindowRule:
    """A truth table: ``table`` (512,), or (1024,) if the initial state counts: +1 black, -1 white, 0 either.

    The index of a window is its nine cells as bits, row by row, the north-western one highest, black as 1; with an
    initial state that is one more bit, the lowest.

    Raises:
        InputError: a table of another length or with other values, or one that leaves everything open.
    """

    table: Signs = field(repr=False)
    text: str = "a truth table"

    def __post_init__(self) -> None:
        object.__setattr__(self, "table", np.asarray(self.table, dtype=np.int8))
        if self.table.shape not in ((512,), (1024,)) or not np.isin(self.table, (-1, 0, 1)).all():
            raise InputError(f"a truth table of shape {self.table.shape}; 512 or 1024 entries -1, 0, +1 wanted")
        if not self.table.any():
            raise InputError(f"{self.text}: no window is black or white; one at least wanted")

    @property
    def with_state(self) -> bool:
        """Whether the initial state counts."""
        return self.table.size == 1024

    @cached_property
    def rows(self) -> Signs:
        """All windows as -1 and +1: (512, 9) or (1024, 10), in the order of the table."""
        return windows(10 if self.with_state else 9)

    @cached_property
    def looks_at(self) -> tuple[int, ...]:
        """The variables (indices into `NAMES`) that change the answer of some window whose answer is not open."""
        index, size = np.arange(self.table.size), self.rows.shape[1]
        found = []
        for variable in range(size):
            turned = self.table[index ^ (1 << (size - 1 - variable))]
            if ((self.table * turned) < 0).any():
                found.append(variable)
        return tuple(found)

    def codes(self, picture: Floats, boundary: Boundary, state: Floats | None) -> Integers:
        """Return the index of every cell's window (rows, cols); above 0 is black, also for the virtual cells."""
        picture = as_numbers("picture", picture, logic=True).astype(np.float64)
        around = pad(picture, 1, boundary, boundary.u) > 0
        rows, cols = picture.shape
        code = np.zeros((rows, cols), dtype=np.int64)
        for k, l in product(range(3), range(3)):
            code = 2 * code + around[k : k + rows, l : l + cols]
        if self.with_state:
            if state is None:
                raise InputError(f"{self.text}: the rule looks at an initial state, and none was given")
            code = 2 * code + (as_numbers("state", state, logic=True) > 0)
        return code

    def answer(self, picture: Floats, boundary: Boundary, state: Floats | None = None) -> Floats:
        """Return the outputs of a picture (rows, cols) by the rule: +1, -1, or 0 if either will do."""
        return self.table[self.codes(picture, boundary, state)].astype(np.float64)


def windows(variables: int) -> Signs:
    """Return all combinations of -1 and +1 (2**variables, variables), the first variable changing slowest."""
    count = np.arange(1 << variables)
    return np.stack([2 * (count >> (variables - 1 - i) & 1) - 1 for i in range(variables)], axis=1).astype(np.int8)


def window_numbers(rows: Signs) -> Integers:
    """Return the index of each window (n, variables) in the order of `windows`."""
    return (rows > 0) @ (1 << np.arange(rows.shape[1])[::-1])


def window_text(row: Signs) -> str:
    """Draw one window as text: its three rows and, if there is one, the initial state."""
    cells = "".join("#" if value > 0 else "." for value in row)
    return f"{cells[:3]}/{cells[3:6]}/{cells[6:9]}" + (f" x={cells[9]}" if len(cells) == 10 else "")
