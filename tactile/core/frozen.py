"""Frozen taxels: pressed taxels whose reading repeats far longer than it ever did, while others change."""

import numpy as np

from cnnsim.support import Flags, Floats

LEAST, LONGER = 25, 4
"""Least number of frames of a frozen reading, and its least ratio to the longest earlier repetition: coarse converters
repeat, too."""


class Frozen:
    """Called with the readings (rows, cols, 3) of each frame, the pressed taxels and those left out for other reasons.

    It returns the left-out taxels with the frozen ones, unless none would remain. A frame in which nothing changes does
    not count: drivers repeat frames.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        from tactile.core.frozen_numba import watch  # numba is slow to import

        self._watch = watch
        self._before: Floats = np.full((*shape, 3), np.nan)
        self._run, self._most = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
        self._frozen: Flags = np.zeros(shape, bool)
        self._named: Flags = np.zeros(shape, bool)

    def __call__(self, values: Floats, pressed: Flags, left_out: Flags) -> Flags:
        """Process a frame."""
        state = self._before, self._run, self._most, pressed, LEAST, LONGER, self._frozen
        if not self._watch(np.ascontiguousarray(values, np.float64), *state):
            return left_out
        both = left_out | self._frozen
        return left_out if both.all() else both

    def words(self) -> str:
        """Return the taxels that are frozen for the first time; empty without any."""
        new = self._frozen & ~self._named
        self._named |= new
        return ", ".join(f"taxel ({i}, {j}) is frozen, left out" for i, j in np.argwhere(new).tolist())
