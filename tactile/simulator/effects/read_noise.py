"""Read noise: white noise of the electronics."""

from collections.abc import Iterable, Iterator

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter
from tactile.simulator.gaussian import LARGEST, GaussianNoise
from tactile.simulator.seen import Seen, sigmas


@effect("frames", normal=True, price=(12, 0.6))
class ReadNoise:
    """Adds normal noise of standard deviation ``rms`` (of full scale) to every reading.

    Statistics: mean 0, independent between readings, channels and frames; normal as ``GaussianNoise`` declares.
    """

    rms: float = parameter(0.002, none=0.0)

    def reach(self, seen: Seen) -> float:
        """Bound of the change."""
        return self.rms * seen.full_scale * min(sigmas(3 * seen.taxels * seen.frames), LARGEST)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Noisy frames; the noise is added in place, for it must be no slower than the field."""
        noise = GaussianNoise(random)
        for batch in stream:
            noise.add(batch.values, self.rms * batch.full_scale)
            yield batch
