"""Low pass: the anti-alias filter before the multiplexer."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter
from tactile.simulator.seen import Seen


@effect("frames", assumed=False)
class LowPass:
    """A filter of first order with the time constant ``time`` [s] in every channel; 0 for none.

    tau dy/dt = x - y, x straight between frames, for which the recursion is exact whatever the interval; before the
    first frame x was as in it. What lies above half the frame rate is not there to be filtered: frames are samples.
    """

    time: float = parameter(1e-3, key="time_ms", unit=1e-3, none=0.0)

    def reach(self, seen: Seen) -> float:
        """Bound of the change: it lags by its time constant."""
        return min(seen.change * seen.rate * self.time, 2 * seen.largest)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Smoothed frames."""
        before, lag, last = np.zeros(0), np.zeros(0), 0.0
        for batch in stream:
            values = np.empty_like(batch.values)
            for n, (t, x) in enumerate(zip(batch.t.tolist(), batch.values, strict=True)):
                if not before.size:
                    before, lag, last = x, np.zeros_like(x), t
                step = max(t - last, 0.0) / self.time
                # the lag x - y decays, and grows with the slope of x
                grown = -np.expm1(-step) / step if step > 0 else 1.0
                lag = np.exp(-step) * lag + grown * (x - before)
                values[n], before, last = x - lag, x, t
            yield replace(batch, values=values)
