"""Clipping: the output of the amplifier is limited by its rails."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames")
class Clipping:
    """Readings are limited to +- ``limit`` of full scale; infinite for none.

    Acts before the converter, which has a range of its own. A clipped reading stays marked valid.
    """

    limit: float = parameter(1.0, 1e-12, none=np.inf)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Limited frames."""
        for batch in stream:
            most = self.limit * batch.full_scale
            yield replace(batch, values=np.clip(batch.values, -most, most))
