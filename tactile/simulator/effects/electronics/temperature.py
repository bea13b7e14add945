"""Temperature: change of gain and zero of all channels while the sensor warms up."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames")
class Temperature:
    """Readings become (1 + ``gain`` T) x + ``offset`` T, T = ``start`` + ``change`` (1 - exp(-t / ``time``)) [K].

    T counts from the temperature at which the skin was calibrated, t from the first frame; ``gain`` [1/K], ``offset``
    [of full scale / K], equal in all channels.
    """

    start: float = parameter(0.0, -np.inf, key="start_k", none=0.0)
    change: float = parameter(5.0, -np.inf, key="change_k", none=0.0)
    time: float = parameter(60.0, 1e-9, key="time_s")
    gain: float = parameter(-0.002, -np.inf, key="gain_per_k")
    offset: float = parameter(0.0005, -np.inf, key="offset_per_k")

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames of a warm sensor."""
        begin = None
        for batch in stream:
            if begin is None and len(batch.t):
                begin = float(batch.t[0])
            warm = self.start - self.change * np.expm1(-(batch.t - (begin or 0.0)) / self.time)
            warm = warm[:, None, None, None]
            yield replace(batch, values=batch.values * (1 + self.gain * warm) + self.offset * batch.full_scale * warm)
