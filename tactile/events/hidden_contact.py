"""Contact of a firm load amid taxels, none of which feels it press."""

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.frame import TaxelArray
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.thresholds.levels import Levels

HIDDEN = 6.0
"""A located load is a contact from so many times the force on that a taxel right under it would feel.

Loads of less lie nearer than a depth to some taxel of arrays that are less than 1.2 depths apart, which feels them.
"""
BEARING = 3
"""Taxels that have to agree on it: one alone locates what its noise says."""
FELT = 1 / 4
"""Of a plane in the binary scale: on."""


class HiddenContact:
    """Where a firm load lies at which no taxel feels it: sqrt(2) depths from it the normal signal is 0.

    So a load amid four taxels may press as hard as it likes; their shear locates it all the same. ``newtons``: what
    `localise` multiplies a signal with.
    """

    def __init__(self, array: TaxelArray, newtons: float) -> None:
        from tactile.events.signals.step_numba import binary  # numba is slow to import

        self._binary, self._positions, self._origin = binary, array.positions(), array.origin
        self._half = array.cols * array.pitch / 2, array.rows * array.pitch / 2
        self._under = HIDDEN * newtons / (2 if array.quantity == "strain" else 1)  # 3 / (2 pi) F / (E z^2), eq. (1)
        self._off = self._on = np.inf

    def set_levels(self, levels: Levels) -> None:
        """Take the levels at which contact of a taxel goes off and on."""
        self._off, self._on = (float(np.median(one[..., 2])) * self._under for one in (levels.off, levels.on))

    def write(self, load: Load, pressing: Floats, use: Flags) -> None:
        """Write such a contact into the plane ``pressing`` (rows, cols), at the nearest taxel in ``use``."""
        if not self._off < load.F:
            return
        x, y = load.x - self._origin[0], load.y - self._origin[1]
        amid = abs(x) <= self._half[0] and abs(y) <= self._half[1]
        known = load.taxels >= BEARING and load.validity in (Validity.INSIDE, Validity.OUTSIDE)
        if pressing.max() > FELT or not (amid and known and use.any()):
            return
        away = np.where(use, np.hypot(self._positions[..., 0] - load.x, self._positions[..., 1] - load.y), np.inf)
        pressing.flat[int(away.argmin())] = self._binary(load.F, self._off, self._on)
