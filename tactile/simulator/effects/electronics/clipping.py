"""Clipping: the amplifier's output ends at its rails."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames")
class Clipping:
    """Readings beyond +- ``limit`` of full scale are ``limit``; infinite for an amplifier without end.

    Before the converter, whose own range ends elsewhere; a clipped reading stays marked valid.
    """

    limit: float = parameter(1.0, 1e-12, none=np.inf)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames between the rails."""
        for batch in stream:
            most = self.limit * batch.full_scale
            yield replace(batch, values=np.clip(batch.values, -most, most))
