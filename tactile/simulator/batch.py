"""Batches of frames of one finger, the input and output of effects on frames."""

import math
from dataclasses import dataclass

from cnnsim.support import Flags, Floats, Integers
from tactile.core.frame import TaxelArray


@dataclass(frozen=True)
class Batch:
    """Consecutive frames of one finger.

    ``t`` (n,) host times [s]; ``sequence`` numbers (n,); ``values`` (n, rows, cols, 3); ``valid`` (n, rows, cols);
    ``unit``: the reading of strain 1, which is 1 for strain and E [Pa] for stress; ``full_scale``: the largest reading
    the electronics are made for, in the unit of the values.
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
        """The values as (n, channels), also without frames."""
        return self.values.reshape(len(self.t), math.prod(self.values.shape[1:]))
