"""Pink noise: the 1/f noise of amplifiers, as much in every octave."""

from collections.abc import Iterable, Iterator

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.simulator.altered import altered
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter, within
from tactile.simulator.gaussian import GaussianNoise
from tactile.simulator.seen import Seen, sigmas

PER_DECADE = 2
"""Relaxations in a decade: with Delta of ln f between two their sum is 1/f but for 2 / cosh(pi^2 / Delta), 8e-4."""
AT_ONCE = 1 << 15
"""Random numbers drawn at once: they stay in the second-level cache."""


@effect("frames", normal=True, assumed=False, price=(50, 10))
class PinkNoise:
    """Adds to every channel noise of the spectrum ``rms``^2 / (f ln(``high`` / ``low``)) between two frequencies [Hz].

    A sum of relaxations (Ornstein-Uhlenbeck processes), each of the same variance and in the middle, by the logarithm
    of its corner frequency, of an equal part of the band: exact at any times. The spectrum is 2/pi (atan(high / f) -
    atan(low / f)) of that said, to 1e-3: within 4 % from 20 low to high / 20, half of it at both ends. ``rms`` (of full
    scale) is the deviation of the whole; mean 0, normal, independent between channels, stationary from the first frame
    on, the same however the frames are cut into pieces.

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
        low, high = np.log10(self.low), np.log10(self.high)
        count = max(1, int(np.ceil(PER_DECADE * (high - low))))
        corners = 2 * np.pi * 10 ** (low + (high - low) * (np.arange(count) + 0.5) / count)
        noise, now, last = GaussianNoise(random), np.zeros((0, 0)), np.nan
        for batch in stream:
            frames, channels = len(batch.t), batch.values[0].size if len(batch.t) else 0
            if not now.size:
                now = np.zeros((count, channels))
            values = batch.values.reshape(frames, channels).copy()
            steps = np.diff(batch.t, prepend=last)
            steps[np.isnan(steps)] = np.inf  # nothing is left of what was before the first frame
            kept = np.exp(-np.maximum(steps, 0)[:, None] * corners)
            scale = self.rms * batch.full_scale / np.sqrt(count)
            block = max(1, AT_ONCE // max(1, now.size))
            for start in range(0, frames, block):
                here = slice(start, start + block)
                fresh = np.zeros((len(kept[here]), *now.shape))
                noise.add(fresh, 1.0)
                _relax(kept[here], np.sqrt(1 - kept[here] ** 2), fresh, now, scale, values[here])
            last = float(batch.t[-1]) if frames else last
            yield altered(batch, values=values.reshape(batch.values.shape))


@kept_njit()
def _relax(kept, new, fresh, now, scale, values):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Add the sum over the relaxations ``now`` (k, channels), times ``scale``, to ``values`` (n, channels).

    From frame to frame of each is left ``kept`` (n, k), and ``new`` (n, k) of ``fresh`` (n, k, channels) is added.
    """
    for n in range(values.shape[0]):
        for k in range(now.shape[0]):
            old, more = kept[n, k], new[n, k]
            for c in range(now.shape[1]):
                now[k, c] = old * now[k, c] + more * fresh[n, k, c]
                values[n, c] += scale * now[k, c]
