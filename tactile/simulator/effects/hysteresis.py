"""Hysteresis: readings depend on whether the load increases or decreases."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter

PLAYS = 4


@effect("frames")
class Hysteresis:
    """y = x + weight (mean of p_k - x), p_k a play of half-width k ``width`` / 4 of full scale, k = 1 .. 4.

    A play follows its input with a dead zone, p <- max(x - r, min(x + r, p)): independent of the rate, with closed
    loops and a memory of turning points. No reading changes by more than weight * 5/8 * width * full scale, half the
    opening of a large cycle. All plays start at 0.

    Source: Prandtl and Ishlinskii; Krasnoselskii and Pokrovskii, Systems with Hysteresis (1989).
    """

    weight: float = parameter(0.2, 0.0, 1.0, none=0.0)
    width: float = parameter(0.05)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with hysteresis."""
        plays = np.zeros((0, 0))
        for batch in stream:
            flat = batch.flat
            if not plays.size:
                plays = np.zeros((PLAYS, flat.shape[1]))
            out = np.empty_like(flat)
            radii = np.arange(1, PLAYS + 1) / PLAYS * self.width * batch.full_scale
            _follow(flat, plays, radii, self.weight, out)
            yield replace(batch, values=out.reshape(batch.values.shape))


@kept_njit()
def _follow(x, plays, radii, weight, out):  # type: ignore[no-untyped-def]  # numba types it at the call
    for n in range(x.shape[0]):
        for c in range(x.shape[1]):
            total = 0.0
            for k in range(radii.size):
                plays[k, c] = max(x[n, c] - radii[k], min(x[n, c] + radii[k], plays[k, c]))
                total += plays[k, c]
            out[n, c] = x[n, c] + weight * (total / radii.size - x[n, c])
