"""Saturation: the end points of each taxel's range, learned from repeated extreme readings."""

import numpy as np

from cnnsim.support import Flags, Floats

LEAST, OFTEN = 12, 5
"""Least number of equal extreme readings that make an end point, and their least ratio to the readings near it."""
BAND = 4.0
"""Width of "near" in units of the jitter: most readings of a noisy signal lie there, and few are its extreme."""


class Saturation:
    """Called with the readings (rows, cols, 3) of each frame; returns the saturated taxels, or None.

    A converter or amplifier outside its range repeats one number, while other readings jitter. Where the converter step
    is coarser than half of the jitter this cannot be distinguished from a held load, and no taxel is marked.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        from tactile.core.saturation_numba import watch  # numba is slow to import

        self._watch = watch
        self._ends = np.full((*shape, 3, 2), -np.inf)
        self._hits = np.zeros((*shape, 3, 2, 2), np.int64)
        self._before, self._steps = np.full((*shape, 3), np.nan), np.full(3, np.inf)
        self._saturated: Flags = np.zeros(shape, bool)
        self._named: Flags = np.zeros(shape, bool)

    def __call__(self, values: Floats, jitter: Floats) -> Flags | None:
        """Process a frame; ``jitter`` (rows, cols, 3) is the unloaded noise from one reading to the next."""
        read = np.ascontiguousarray(values, np.float64)
        state = self._ends, self._hits, self._steps, LEAST, OFTEN, self._saturated
        return self._saturated if self._watch(read, self._before, jitter, BAND, *state) else None

    def words(self, values: Floats) -> str:
        """Return the taxels that are saturated for the first time, with their readings; empty without any."""
        new = self._saturated & ~self._named
        self._named |= new
        said = [f"({i}, {j}) at {max(values[i, j].tolist(), key=abs):g}" for i, j in np.argwhere(new).tolist()]
        return f"taxels that stand at an end of their range: {', '.join(said)}" if said else ""
