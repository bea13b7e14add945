"""Temperature: gain and zero of all channels change as the sensor warms up."""

import math
from collections.abc import Iterable, Iterator

import numpy as np

from tactile.simulator.altered import altered
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter
from tactile.simulator.seen import Seen


@effect("frames", assumed=False, price=(8, 0.8))
class Temperature:
    """Readings become (1 + ``gain`` T) x + ``offset`` T, T = ``start`` + ``change`` (1 - exp(-t / ``time``)) [K].

    T counts from the temperature at which the skin was calibrated, t from the first frame; ``gain`` [1/K], ``offset``
    [of full scale / K], alike in all channels.
    """

    start: float = parameter(0.0, -np.inf, key="start_k", none=0.0)
    change: float = parameter(5.0, -np.inf, key="change_k", none=0.0)
    time: float = parameter(60.0, 1e-9, key="time_s")
    gain: float = parameter(-0.002, -np.inf, key="gain_per_k")
    offset: float = parameter(0.0005, -np.inf, key="offset_per_k")

    def reach(self, seen: Seen) -> float:
        """Bound of the change: T goes from its start to its end without turning."""
        warmest = self._warmest(seen)
        return warmest * (abs(self.gain) * seen.largest + abs(self.offset) * seen.full_scale)

    def passes(self, seen: Seen) -> float:
        """By what a change before it may grow."""
        return 1 + self._warmest(seen) * abs(self.gain)

    def _warmest(self, seen: Seen) -> float:
        return max(abs(self.start), abs(self.start - self.change * math.expm1(-seen.duration / self.time)))

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames of a warm sensor."""
        begin = None
        for batch in stream:
            if begin is None and len(batch.t):
                begin = float(batch.t[0])
            warm = self.start - self.change * np.expm1(-(batch.t - (begin or 0.0)) / self.time)
            warm = warm[:, None, None, None]
            yield altered(batch, values=batch.values * (1 + self.gain * warm) + self.offset * batch.full_scale * warm)
