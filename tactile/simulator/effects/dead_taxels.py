"""Dead and stuck taxels: they read nothing, or always the same."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter, within


@effect("frames", random=True)
class DeadTaxels:
    """Each taxel is dead with probability ``dead`` (reads 0) or stuck with probability ``stuck``.

    A stuck taxel's channels read one level each for the whole scene, uniform in -1 .. 1 of full scale. Which taxels
    are concerned is drawn once a finger, independently. Their readings stay marked valid: nobody told the driver.
    """

    dead: float = parameter(0.01, 0.0, 1.0, none=0.0)
    stuck: float = parameter(0.005, none=0.0)

    def __post_init__(self) -> None:
        within("stuck", self.stuck, 0.0, 1.0 - self.dead)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with silent taxels."""
        lot, level = np.zeros(0), np.zeros(0)
        for batch in stream:
            if not lot.size:
                lot = random.uniform(size=batch.array.shape)
                level = random.uniform(-1, 1, (*batch.array.shape, 3)) * batch.full_scale
            dead, stuck = lot < self.dead, (lot >= self.dead) & (lot < self.dead + self.stuck)
            values = batch.values.copy()
            values[:, dead] = 0
            values[:, stuck] = level[stuck]
            yield replace(batch, values=values)
