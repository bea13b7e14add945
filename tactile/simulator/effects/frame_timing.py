"""Frame timing: frames are early, late, repeated or lost."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames", random=True)
class FrameTiming:
    """Host times are off by a normal ``jitter`` [s]; frames repeat the one before, or get lost, at random.

    ``repeats`` and ``drops`` are probabilities. A repeated frame has the values and the sequence number of the last
    fresh one; a lost one leaves a gap in both times and numbers. Frames are drawn independently. Times never decrease:
    a frame that would be earlier than the one before gets its time. The first frame is neither repeated nor lost.
    """

    jitter: float = parameter(1e-4, key="jitter_ms", unit=1e-3, none=0.0)
    repeats: float = parameter(0.001, 0.0, 1.0, none=0.0)
    drops: float = parameter(0.001, 0.0, 1.0, none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames as they are received."""
        fates, delays = random.spawn(2)
        last_t, fresh_values, fresh_sequence = 0.0, np.zeros(0), 0
        for batch in stream:
            count = len(batch.t)
            lots = fates.uniform(size=(count, 2))
            late = delays.standard_normal(count) * self.jitter
            repeated, lost = lots[:, 0] < self.repeats, lots[:, 1] < self.drops
            if not fresh_values.size:
                repeated[:1] = lost[:1] = False
                fresh_values = batch.values[0] if count else fresh_values
            t = np.maximum.accumulate(np.maximum(batch.t + late, last_t))
            last_t = float(t[-1]) if count else last_t
            # index of the last fresh frame, -1 for the one before this batch
            source = np.maximum.accumulate(np.where(repeated, -1, np.arange(count)))
            values = np.concatenate([batch.values, fresh_values[None]])[source] if repeated.any() else batch.values
            sequence = np.append(batch.sequence, fresh_sequence)[source]
            if count:
                fresh_values, fresh_sequence = values[-1], int(sequence[-1])
            keep = ~lost
            yield replace(batch, t=t[keep], sequence=sequence[keep], values=values[keep], valid=batch.valid[keep])
