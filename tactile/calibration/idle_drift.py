"""Drift of the pressing of idle force taxels: what the tare follows of it, and what a slow touch gets back."""

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.frame import NORMAL

LEAST, COMMON = 0.25, 0.5
"""What all drift by: the quantile of their pressing, at most so many dead bands of it a second; a touch presses some
more than others."""
ALONE, UNLIKE = 0.02, 0.5
"""Dead bands of pressing a second that a taxel drifts alone, and part of what all drift by that is its own."""
FASTEST, FARTHEST = 1.5, 10.0
"""Dead bands of pressing a second that drift goes at most during a contact, and dead bands in all."""


class IdleDrift:
    """How far the offset of idle taxels goes with their drift.

    The pressing of all follows the lower quartile of them, `COMMON` at most, and on each `ALONE` beside that and
    `UNLIKE` of it: a touch that presses alike on all and slower is taken for drift. Once a slow touch is told of, what
    was followed since one taxel rose above the others is given back to it.

    Args:
        limit: Dead bands (3,) or (rows, cols, 3) [unit of the frames].
        inward: Sign of a pressing load, one or (rows, cols).
    """

    def __init__(self, limit: Floats, inward: float | Floats) -> None:
        self._limit, self._inward = np.abs(limit)[..., NORMAL], inward
        self._before: Floats | None = None  # offset when a taxel began to rise faster than drift goes

    def follow(self, offset: Floats, away: Floats, known: Flags, sigma: Floats, seconds: float) -> Floats:
        """Return the offset (rows, cols, 3) after so many seconds, where a block's mean is so far ``away`` from it."""
        limit, press = self._limit * seconds, away[..., NORMAL]
        common = np.clip(np.nanquantile(press[known], LEAST) if known.any() else 0.0, -COMMON * limit, COMMON * limit)
        own, left = ALONE * limit + UNLIKE * np.abs(common), press - common
        if not (self._inward * left > own + sigma[..., NORMAL])[known].any():
            self._before = None
        elif self._before is None:
            self._before = offset
        followed = offset + away
        followed[..., NORMAL] = offset[..., NORMAL] + common + np.clip(left, -own, own)
        return followed

    def give_back(self, offset: Floats) -> Floats | None:
        """Return the offset without what was followed since one taxel rose, None where none did."""
        if self._before is None:
            return None
        back = offset.copy()
        back[..., NORMAL] = self._before[..., NORMAL]
        return back

    def forget(self) -> None:
        """Take note of a contact: no taxel has begun to rise."""
        self._before = None

    def in_contact(self, seconds: float) -> Floats:
        """Return how far pressing may have drifted in a contact of so many seconds that is over."""
        return self._limit[..., None] * min(FASTEST * seconds, FARTHEST)
