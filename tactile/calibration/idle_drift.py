"""Drift compensation of idle force taxels: the tare follows their drift; a slow touch undoes the compensation."""

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.frame import NORMAL

LEAST, COMMON = 0.25, 0.5
"""Common drift: quantile of the normal forces, and its largest rate in dead bands a second. A low quantile, because a
touch presses some taxels more than others."""
ALONE, UNLIKE = 0.02, 0.5
"""Drift of one taxel beyond the common one: dead bands a second, and part of the common drift."""
FASTEST, FARTHEST = 1.5, 10.0
"""Largest drift in a contact: dead bands a second, and dead bands in all."""


class IdleDrift:
    """Compensation of the drift of idle taxels.

    The offset follows the lower quartile of the normal forces, at most `COMMON`, and each taxel its own drift beyond
    it, at most `ALONE` plus `UNLIKE` of the common one. A slower touch that presses all taxels equally counts as drift.
    Once a slow touch is detected, the compensation since one taxel rose above the others is undone.

    Args:
        limit: Dead bands (3,) or (rows, cols, 3) [unit of the frames].
        inward: Sign of a pressing load, one or (rows, cols).
    """

    def __init__(self, limit: Floats, inward: float | Floats) -> None:
        self._limit, self._inward = np.abs(limit)[..., NORMAL], inward
        self._before: Floats | None = None  # offset when a taxel began to rise faster than drift

    def follow(self, offset: Floats, away: Floats, known: Flags, sigma: Floats, seconds: float) -> Floats:
        """Return the offset (rows, cols, 3) after ``seconds``, for a block whose mean is ``away`` from the offset."""
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
        """Return the offset without the compensation since one taxel rose, None if none did."""
        if self._before is None:
            return None
        back = offset.copy()
        back[..., NORMAL] = self._before[..., NORMAL]
        return back

    def forget(self) -> None:
        """Note a contact: the compensation since a taxel rose is kept from now on."""
        self._before = None

    def in_contact(self, seconds: float) -> Floats:
        """Return the largest drift of the normal forces in a contact of ``seconds``."""
        return self._limit[..., None] * min(FASTEST * seconds, FARTHEST)
