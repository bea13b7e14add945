"""Dead and stuck taxels: they read 0, or a constant."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter, within


@effect("frames", random=True)
class DeadTaxels:
    """Each taxel is dead with probability ``dead`` (reads 0) or stuck with probability ``stuck``.

    Each channel of a stuck taxel reads one value for the whole scene, uniform in -1 .. 1 of full scale. The taxels are
    drawn independently, once per finger. Their readings stay marked valid.
    """

    dead: float = parameter(0.01, 0.0, 1.0, none=0.0)
    stuck: float = parameter(0.005, none=0.0)

    def __post_init__(self) -> None:
        within("stuck", self.stuck, 0.0, 1.0 - self.dead)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with dead and stuck taxels."""
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
