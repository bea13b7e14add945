"""Batches of frames of one finger, which the effects on frames take and give."""

import math
from dataclasses import dataclass

from cnnsim.support import Flags, Floats, Integers
from tactile.core.frame import TaxelArray


@dataclass(frozen=True)
class Batch:
    """Consecutive frames of one finger.

    ``t`` (n,) host times [s]; ``sequence`` (n,); ``values`` (n, rows, cols, 3), whoever holds the batch may write
    into it; ``valid`` (n, rows, cols); ``unit``: what a reading of strain 1 is, 1 for strain and E for stress [Pa];
    ``full_scale``: the largest reading the electronics are made for, in the unit of the values.
    """

    array: TaxelArray
    unit: float
    full_scale: float
    t: Floats
    sequence: Integers
    values: Floats
    valid: Flags

    @property
    def flat(self) -> Floats:
        """The values as (n, channels), of no frames too."""
        return self.values.reshape(len(self.t), math.prod(self.values.shape[1:]))
