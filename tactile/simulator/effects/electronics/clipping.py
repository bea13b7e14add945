"""Clipping: the amplifier's output ends at its rails."""

from collections.abc import Iterable, Iterator

import numpy as np

from tactile.simulator.altered import altered
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter
from tactile.simulator.seen import Seen


@effect("frames", assumed=False, price=(3, 0.2))
class Clipping:
    """Readings beyond +- ``limit`` of full scale are ``limit``; infinite for an amplifier without end.

    Before the converter, whose own range ends elsewhere; a clipped reading stays marked valid.
    """

    limit: float = parameter(1.0, 1e-12, none=np.inf)

    def reach(self, seen: Seen) -> float:
        """Bound of the change."""
        return max(seen.largest - self.limit * seen.full_scale, 0.0)

    def behind(self, seen: Seen) -> Seen:
        """The bounds behind it."""
        most = self.limit * seen.full_scale
        low, high = (min(max(end, -most), most) for end in seen.normal)
        return seen._replace(largest=min(seen.largest, most), normal=(low, high))

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames between the rails."""
        for batch in stream:
            most = self.limit * batch.full_scale
            yield altered(batch, values=np.clip(batch.values, -most, most))
