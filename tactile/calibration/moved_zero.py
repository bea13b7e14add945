"""Zero of a force array that moved: still blocks of frames in which most taxels read a pull."""

from collections.abc import Sequence

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import NORMAL

PULL = 6.0
"""Standard deviations of a block's mean beyond which a reading is a pull."""
FRAMES = 20
"""Least number of frames in a block."""


class MovedZero:
    """Called with each block; returns the time [s] of the fall at the second still pull in a row, else None.

    A pressed sensor cannot read a lasting pull: it was pressed during the tare, or its zero moved, as when it is seated
    anew. ``fell`` is the time of the fall after the first such block.

    Args:
        limit: Dead bands (3,) or (rows, cols, 3) [unit of the frames].
        inward: Sign of a pressing load, one or (rows, cols).
    """

    def __init__(self, limit: Floats, inward: float | Floats) -> None:
        self.fell: float | None = None
        self._limit, self._inward = np.abs(limit), inward
        self._before: tuple[Sequence[float], Floats] | None = None  # times and pressing of the block before

    def __call__(self, times: Sequence[float], block: Floats, away: Floats | None, sigma: Floats) -> float | None:
        """Process a block (n, rows, cols, 3) at ``times``.

        ``away`` (rows, cols, 3): its mean less the offset, None if it is not still; ``sigma``: its noise.
        """
        times, press = list(times[: len(block)]), np.nansum(self._inward * block[..., NORMAL], axis=(1, 2))
        before, self._before = self._before, (times, press)
        fell, self.fell = self.fell, None
        if away is None or not self._pulls(away, sigma):
            return None
        if fell is None:
            if before is not None:
                times, press = [*before[0], *times], np.concatenate([before[1], press])
            self.fell = times[int(np.argmin(np.diff(press))) + 1]
        return fell

    def _pulls(self, away: Floats, sigma: Floats) -> bool:
        """Return whether most taxels read a pull beyond limit and noise, and their sum is far beyond them."""
        press = self._inward * away[..., NORMAL]
        limit = np.maximum(self._limit, PULL * sigma / np.sqrt(FRAMES))[..., NORMAL]
        most = bool((press < -limit).sum() * 2 > (press > 0).sum() + 1)
        return most and float(np.nansum(press)) < -2 * float(np.median(limit))
