"""Quantisation: the steps of the analogue-to-digital converter, and the end of its range."""

from collections.abc import Iterable, Iterator

import numpy as np

from tactile.simulator.altered import altered
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter
from tactile.simulator.seen import Seen


@effect("frames", price=(5, 0.8))
class Quantisation:
    """Readings become whole numbers of steps of 2 ``span`` / 2^``bits`` of full scale.

    The numbers go from -2^(bits-1) to 2^(bits-1) - 1. Inside the range the error is at most half a step (uniform for
    a busy signal, mean square step^2 / 12); beyond it the reading saturates. ``bits`` = 0 is no converter."""

    bits: int = parameter(12, 0, 48, none=0)
    span: float = parameter(1.5, 1e-12)

    def reach(self, seen: Seen) -> float:
        """Bound of the change: half a step, and what lies beyond the range."""
        if self.bits == 0:
            return 0.0
        return self.grain(seen) / 2 + max(seen.largest - self.span * seen.full_scale + self.grain(seen), 0.0)

    def grain(self, seen: Seen) -> float:
        """What the smallest change before it may become: a step."""
        return self.span * seen.full_scale / 2.0 ** (self.bits - 1) if self.bits else 0.0

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames in steps."""
        for batch in stream:
            half = 2.0 ** (self.bits - 1)
            step = self.span * batch.full_scale / half
            yield altered(batch, values=np.clip(np.rint(batch.values / step), -half, half - 1) * step)
