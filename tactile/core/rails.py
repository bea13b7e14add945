"""Rails: the ends of every taxel's range, learned from readings that stop there although they are noisy elsewhere."""

import numpy as np

from cnnsim.support import Flags, Floats

LEAST, OFTEN = 12, 5
"""So many readings of exactly the same extreme make an end of the range, if they are so many times those near it."""
BAND = 4.0
"""Near is within so many times the jitter: of a noisy signal most readings lie there, and few are its extreme."""


class Rails:
    """Called with the readings (rows, cols, 3) of each frame, gives the taxels that are at an end, or None.

    A converter or an amplifier that is driven out of its range gives the same number again and again, where readings
    else jitter. Where the steps of the readings are coarser than half of the jitter that cannot be told from a load
    that is held, and nothing is marked.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        from tactile.core.rails_numba import watch  # numba is slow to import

        self._watch = watch
        self._ends = np.full((*shape, 3, 2), -np.inf)
        self._hits = np.zeros((*shape, 3, 2, 2), np.int64)
        self._before, self._steps = np.full((*shape, 3), np.nan), np.full(3, np.inf)
        self._saturated: Flags = np.zeros(shape, bool)

    def __call__(self, values: Floats, jitter: Floats) -> Flags | None:
        """Take a frame; ``jitter`` (rows, cols, 3) from one reading to the next while nothing presses."""
        read = np.ascontiguousarray(values, np.float64)
        self._watch(
            read, self._before, jitter, BAND, self._ends, self._hits, self._steps, (LEAST, OFTEN), self._saturated
        )
        return self._saturated if self._saturated.any() else None
