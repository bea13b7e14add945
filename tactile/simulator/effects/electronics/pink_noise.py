"""Pink noise: 1/f noise of amplifiers."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter, within

PER_DECADE = 2
"""Relaxations per decade: with Delta of ln f between two, their sum is 1/f to 2 / cosh(pi^2 / Delta) = 8e-4."""
BLOCK = 1 << 20
"""Random numbers drawn in one call: 8 MiB."""


@effect("frames", random=True)
class PinkNoise:
    """Adds to every channel noise of the spectrum ``rms``^2 / (f ln(``high`` / ``low``)) between two frequencies [Hz].

    A sum of relaxations (Ornstein-Uhlenbeck processes) of equal variance, with corner frequencies at equal distances
    of their logarithm; exact at any sample times. The spectrum is that above times 2/pi (atan(high / f) -
    atan(low / f)), to 1e-3: within 4 % from 20 low to high / 20, half at both ends. ``rms`` (of full scale) is the
    standard deviation of the whole; mean 0, normal, independent between channels, stationary from the first frame on.

    Source: Milotti, 1/f noise: a pedagogical review (2002), sect. 2.
    """

    rms: float = parameter(0.001, none=0.0)
    low: float = parameter(0.01, 1e-9, key="low_hz")
    high: float = parameter(1000.0, 1e-9, key="high_hz")

    def __post_init__(self) -> None:
        within("high", self.high, self.low)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Noisy frames."""
        low, high = np.log10(self.low), np.log10(self.high)
        count = max(1, int(np.ceil(PER_DECADE * (high - low))))
        corners = 2 * np.pi * 10 ** (low + (high - low) * (np.arange(count) + 0.5) / count)
        now, last = np.zeros((0, 0)), np.nan
        for batch in stream:
            frames, channels = len(batch.t), batch.values[0].size if len(batch.t) else 0
            if not now.size:
                now = np.zeros((count, channels))
            values = batch.values.reshape(frames, channels).copy()
            steps = np.diff(batch.t, prepend=last)
            steps[np.isnan(steps)] = np.inf  # the first frame is independent of the past
            kept = np.exp(-np.maximum(steps, 0)[:, None] * corners)
            scale = self.rms * batch.full_scale / np.sqrt(count)
            block = max(1, BLOCK // max(1, now.size))
            for start in range(0, frames, block):
                here = slice(start, start + block)
                fresh = random.standard_normal((len(kept[here]), *now.shape))
                _relax(kept[here], np.sqrt(1 - kept[here] ** 2), fresh, now, scale, values[here])
            last = float(batch.t[-1]) if frames else last
            yield replace(batch, values=values.reshape(batch.values.shape))


@kept_njit()
def _relax(kept, new, fresh, now, scale, values):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Add ``scale`` times the sum of the relaxations ``now`` (k, channels) to ``values`` (n, channels).

    In every frame now = kept now + new fresh, with ``kept`` and ``new`` (n, k) and ``fresh`` (n, k, channels).
    """
    for n in range(values.shape[0]):
        for k in range(now.shape[0]):
            old, more = kept[n, k], new[n, k]
            for c in range(now.shape[1]):
                now[k, c] = old * now[k, c] + more * fresh[n, k, c]
                values[n, c] += scale * now[k, c]
