"""Multiplex skew: one converter reads the channels one after the other."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames")
class MultiplexSkew:
    """Channel k of n is read (n - 1 - k) ``slot`` [s] before the time of the frame; 0 for all at that time.

    Channels are ordered by row, column and component. Readings are linear between frames; a channel that would be read
    before the previous frame is read with it.
    """

    slot: float = parameter(1e-5, key="slot_us", unit=1e-6, none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Skewed frames."""
        before, last = np.zeros(0), 0.0
        for batch in stream:
            if not len(batch.t):
                yield batch
                continue
            if not before.size:
                before, last = batch.values[0], float(batch.t[0])
            shape = batch.values.shape[1:]
            early = np.arange(int(np.prod(shape)) - 1, -1, -1).reshape(shape) * self.slot
            steps = np.maximum(np.diff(batch.t, prepend=last), 1e-300)[:, None, None, None]
            previous = np.concatenate([before[None], batch.values[:-1]])
            before, last = batch.values[-1], float(batch.t[-1])
            share = np.minimum(early, steps) / steps
            yield replace(batch, values=batch.values + share * (previous - batch.values))
