"""Pink noise: the 1/f noise of amplifiers, as much in every octave."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter, within
from tactile.simulator.seen import Seen, sigmas

PER_DECADE = 3
"""Relaxations in a decade: their sum's spectrum is 1/f to 3 %."""


@effect("frames", normal=True, assumed=False)
class PinkNoise:
    """Adds to every channel noise of the spectrum ``rms``^2 / (f ln(``high`` / ``low``)) between two frequencies [Hz].

    A sum of relaxations (Ornstein-Uhlenbeck processes), three in a decade, evenly in the logarithm of their corner
    frequencies, each of the same variance: exact at any times. ``rms`` (of full scale) is the deviation of the whole;
    mean 0, normal, independent between channels, stationary from the first frame on.

    Source: Milotti, 1/f noise: a pedagogical review (2002), sect. 2.
    """

    rms: float = parameter(0.001, none=0.0)
    low: float = parameter(0.01, 1e-9, key="low_hz")
    high: float = parameter(1000.0, 1e-9, key="high_hz")

    def __post_init__(self) -> None:
        within("high", self.high, self.low)

    def reach(self, seen: Seen) -> float:
        """Bound of the change."""
        return self.rms * seen.full_scale * sigmas(3 * seen.taxels * seen.frames)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Noisy frames."""
        count = 1 + int(np.ceil(PER_DECADE * np.log10(self.high / self.low)))
        corners = 2 * np.pi * np.geomspace(self.low, self.high, count)
        now, last = np.zeros(0), 0.0
        for batch in stream:
            added = np.empty_like(batch.values)
            for n, t in enumerate(batch.t.tolist()):
                shape = (count, *batch.values.shape[1:])
                fresh = random.standard_normal(shape)
                kept = np.exp(-corners * max(t - last, 0.0)).reshape(-1, 1, 1, 1)
                now = fresh if not now.size else kept * now + np.sqrt(1 - kept**2) * fresh
                added[n], last = now.sum(axis=0), t
            yield replace(batch, values=batch.values + self.rms * batch.full_scale / np.sqrt(count) * added)
