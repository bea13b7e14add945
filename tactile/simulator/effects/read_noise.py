"""Read noise: white noise of the electronics."""

from collections.abc import Iterable, Iterator

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter
from tactile.simulator.gaussian import GaussianNoise


@effect("frames", random=True)
class ReadNoise:
    """Adds normal noise of standard deviation ``rms`` (of full scale) to every reading.

    Statistics: mean 0, independent between readings, channels and frames; normal as ``GaussianNoise`` declares.
    """

    rms: float = parameter(0.002, none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Noisy frames; the noise is added in place, for it must be no slower than the field."""
        noise = GaussianNoise(random)
        for batch in stream:
            noise.add(batch.values, self.rms * batch.full_scale)
            yield batch
