"""Data of a taxel plane that is drawn: its array, its strongest frame and its located loads, in drawn units."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.calibration.tare_check import UNITS
from tactile.core.frame import NORMAL, TaxelArray
from tactile.inverse.validity import Validity
from tactile.output.collected import Columns

SURE = (Validity.INSIDE, Validity.OUTSIDE)
"""Validities of certain positions; others are marked as uncertain."""
SQUARES = 16
"""Largest number of taxels per side that are drawn one by one; larger arrays are a map of the strongest frame."""
ARROWS = 16
"""Largest number of arrows per side; larger arrays show means of blocks."""
MARGIN = 1.2
"""Margin around the taxels over the depth."""


@dataclass(frozen=True)
class Plane:
    """The taxel plane of a finger: its axes, array, columns, strongest frame, and (n, 4) t, x, y, F of further loads.

    ``dead_band`` of the median taxel's shear in the strongest frame.
    """

    axis: Any
    array: TaxelArray
    columns: Columns
    strongest: Floats | None
    others: Floats
    dead_band: float | None

    @property
    def is_force(self) -> bool:
        """Whether the plane shows forces of taxels: no load is located."""
        return self.array.quantity == "force"

    @property
    def is_map(self) -> bool:
        """Whether the strongest frame is drawn."""
        return self.strongest is not None and (self.is_force or max(self.array.shape) > SQUARES)

    @property
    def half(self) -> float:
        """Half the width [mm] of the axes."""
        side = (max(self.array.shape) - 1) * self.array.pitch
        return 1e3 * (side / 2 + max(self.array.pitch, MARGIN * self.array.depth))

    @property
    def block(self) -> int:
        """Side of the blocks of taxels of which arrows show the mean."""
        return -(-max(self.array.shape) // ARROWS)

    @property
    def normal(self) -> Floats:
        """Pressing in the strongest frame (rows, cols), in the unit of `UNITS`, NaN without a reading."""
        assert self.strongest is not None
        inward = 1.0 if self.is_force else -1.0
        return inward * UNITS[self.array.quantity][0] * self.strongest[..., NORMAL]

    def loads(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return t, x, y [mm] and abs(F) of the certain loads."""
        sure = np.isfinite(self.columns.x) & np.isin(self.columns.validity, SURE)
        one = np.stack([self.columns.t, self.columns.x, self.columns.y, self.columns.F])[:, sure]
        more = self.others[np.isin(self.others[:, 0], one[0])].T
        t, x, y, force = np.concatenate([one, more], axis=1)
        return t, 1e3 * x, 1e3 * y, np.where(np.isfinite(force), np.abs(force), 0.0)


def blocks(plane: Floats, block: int) -> Floats:
    """Return the means (rows, cols, 2) of blocks of taxels, ignoring NaN; NaN for empty blocks."""
    if block == 1:
        return plane

    def total(values: Floats) -> Floats:
        rows, cols = (np.arange(0, size, block) for size in plane.shape[:2])
        sums: Floats = np.add.reduceat(np.add.reduceat(values, rows, axis=0), cols, axis=1)
        return sums

    count = total(np.isfinite(plane).astype(float))
    return total(np.nan_to_num(plane)) / np.where(count, count, np.nan)


def round_number(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is at most a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))
