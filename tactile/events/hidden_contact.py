"""Hidden contact: a firm located load between taxels, none of which is pressed."""

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.frame import TaxelArray
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.thresholds.levels import Levels

HIDDEN = 6.0
"""Force over the contact level of a taxel right below, from which a located load is a contact.

A weaker load presses some taxel, if the pitch is below 1.2 depths: one lies nearer than a depth.
"""
BEARING = 3
"""Least number of taxels that agree on the load: a single taxel locates its own noise."""
ON = 1 / 4
"""Value of a plane in the binary scale at which it goes on."""


class HiddenContact:
    """Marks the contact of a firm load that presses no taxel: sqrt(2) depths from it the normal signal is 0.

    The shear of the taxels locates such a load. ``newtons``: the factor of `localise` from signal to force.
    """

    def __init__(self, array: TaxelArray, newtons: float) -> None:
        from tactile.events.signals.step_numba import binary  # numba is slow to import

        self._binary, self._positions, self._origin = binary, array.positions(), array.origin
        self._half = array.cols * array.pitch / 2, array.rows * array.pitch / 2
        self._under = HIDDEN * newtons / (2 if array.quantity == "strain" else 1)  # 3 / (2 pi) F / (E z^2), eq. (1)
        self._off = self._on = np.inf

    def set_levels(self, levels: Levels) -> None:
        """Set the levels at which the contact of a taxel goes off and on."""
        self._off, self._on = (float(np.median(one[..., 2])) * self._under for one in (levels.off, levels.on))

    def write(self, load: Load, pressing: Floats, use: Flags) -> None:
        """Write a contact between taxels into the plane ``pressing`` (rows, cols), at the nearest taxel in ``use``."""
        if not self._off < load.F:
            return
        x, y = load.x - self._origin[0], load.y - self._origin[1]
        amid = abs(x) <= self._half[0] and abs(y) <= self._half[1]
        known = load.taxels >= BEARING and load.validity in (Validity.INSIDE, Validity.OUTSIDE)
        if pressing.max() > ON or not (amid and known and use.any()):
            return
        away = np.where(use, np.hypot(self._positions[..., 0] - load.x, self._positions[..., 1] - load.y), np.inf)
        pressing.flat[int(away.argmin())] = self._binary(load.F, self._off, self._on)
