"""Drift of the zero of every channel."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames", random=True)
class Drift:
    """Adds full scale * (``rate`` * s_c * t + ``walk`` * W_c(t)) to channel c, t from the first frame.

    Statistics: s_c is standard normal, drawn once per channel; W_c is a Wiener process. The offset is normal with mean
    0 and variance full scale^2 (rate^2 t^2 + walk^2 t), independent between channels, for any sample
    interval. ``rate`` [1/s], ``walk`` [1/sqrt(s)].
    """

    rate: float = parameter(2e-4, key="rate_per_s", none=0.0)
    walk: float = parameter(2e-4, key="walk_per_sqrt_s", none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with drift."""
        slope, walked, start, last = np.zeros(0), np.zeros(0), 0.0, 0.0
        for batch in stream:
            shape = batch.values.shape[1:]
            if not len(batch.t):
                yield batch
                continue
            if not slope.size:
                slope, walked = random.standard_normal(shape), np.zeros(shape)
                start = last = float(batch.t[0])
            steps = np.sqrt(np.maximum(np.diff(batch.t, prepend=last), 0))
            offset = random.standard_normal(batch.values.shape) * steps[:, None, None, None]
            offset[:1] += walked
            np.cumsum(offset, axis=0, out=offset)
            walked, last = offset[-1].copy(), float(batch.t[-1])
            offset *= self.walk
            offset += self.rate * (batch.t - start)[:, None, None, None] * slope
            yield replace(batch, values=batch.values + batch.full_scale * offset)
