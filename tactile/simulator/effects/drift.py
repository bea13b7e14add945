"""Drift: the zero of every channel wanders."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.checks import within


@dataclass(frozen=True)
class Drift:
    """Adds full scale * (``rate`` * s_c * t + ``walk`` * W_c(t)) to channel c, t from the first frame.

    Statistics: s_c is standard normal, drawn once a channel; W_c a Wiener process, so the offset is normal of mean
    0 and variance full scale^2 (rate^2 t^2 + walk^2 t), independent between channels, whatever the sample
    interval. ``rate`` [1/s], ``walk`` [1/sqrt(s)].
    """

    rate: float = 2e-4
    walk: float = 2e-4

    STAGE: ClassVar[str] = "frames"
    RANDOM: ClassVar[bool] = True
    KEYS: ClassVar[Mapping[str, tuple[str, float]]] = {"rate_per_s": ("rate", 1.0), "walk_per_sqrt_s": ("walk", 1.0)}
    NONE: ClassVar[Mapping[str, Any]] = {"rate": 0.0, "walk": 0.0}

    def __post_init__(self) -> None:
        within("rate", self.rate)
        within("walk", self.walk)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with wandering zeros."""
        if self.rate == 0 and self.walk == 0:
            yield from stream
            return
        slope, walked, start, last = np.zeros(0), np.zeros(0), 0.0, 0.0
        for batch in stream:
            shape = batch.values.shape[1:]
            if not slope.size and len(batch.t):
                slope, walked = random.standard_normal(shape), np.zeros(shape)
                start = last = float(batch.t[0])
            steps = np.sqrt(np.maximum(np.diff(batch.t, prepend=last), 0))
            offset = random.standard_normal(batch.values.shape) * steps[:, None, None, None]
            offset[:1] += walked
            np.cumsum(offset, axis=0, out=offset)
            if len(batch.t):
                walked, last = offset[-1].copy(), float(batch.t[-1])
            offset *= self.walk
            offset += self.rate * (batch.t - start)[:, None, None, None] * slope
            yield replace(batch, values=batch.values + batch.full_scale * offset)
