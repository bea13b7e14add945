"""Read noise: white noise of the electronics."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames", random=True)
class ReadNoise:
    """Adds normal noise of standard deviation ``rms`` (of full scale) to every reading.

    Statistics: mean 0, normal, independent between readings, channels and frames.
    """

    rms: float = parameter(0.002, none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Noisy frames."""
        for batch in stream:
            noise = random.standard_normal(batch.values.shape)
            yield replace(batch, values=batch.values + self.rms * batch.full_scale * noise)
