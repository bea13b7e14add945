"""Low pass: the anti-alias filter before the multiplexer."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter
from tactile.simulator.effects.viscoelastic import recur

ALL = np.ones(1)


@effect("frames")
class LowPass:
    """A filter of first order with the time constant ``time`` [s] in every channel; 0 for none.

    tau dy/dt = x - y with x linear between frames, for which the recursion is exact for any interval; before the first
    frame x is constant. Signals above half the frame rate are not simulated.
    """

    time: float = parameter(1e-3, key="time_ms", unit=1e-3, none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Filtered frames."""
        before, lag, last = np.zeros(0), np.zeros((0, 0)), 0.0
        for batch in stream:
            flat = batch.flat
            if not before.size and len(flat):
                before, lag, last = flat[0].copy(), np.zeros((1, flat.shape[1])), float(batch.t[0])
            steps = np.maximum(np.diff(batch.t, prepend=last), 0)[:, None] / self.time
            # the lag x - y relaxes and is driven by the slope of x
            grown = np.where(steps > 0, -np.expm1(-steps) / np.where(steps > 0, steps, 1), 1.0)
            late = np.empty_like(flat)
            recur(flat, before, lag, np.exp(-steps), grown, ALL, late)
            last = float(batch.t[-1]) if len(batch.t) else last
            yield replace(batch, values=(flat - late).reshape(batch.values.shape))
