"""Dead and stuck taxels: they read nothing, or always the same."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.checks import within


@dataclass(frozen=True)
class DeadTaxels:
    """Each taxel is dead with probability ``dead`` (reads 0) or stuck with probability ``stuck``.

    A stuck taxel's channels read one level each for the whole scene, uniform in -1 .. 1 of full scale. Which taxels
    are concerned is drawn once a finger, independently. Their readings stay marked valid: nobody told the driver.
    """

    dead: float = 0.01
    stuck: float = 0.005

    STAGE: ClassVar[str] = "frames"
    RANDOM: ClassVar[bool] = True
    KEYS: ClassVar[Mapping[str, tuple[str, float]]] = {"dead": ("dead", 1.0), "stuck": ("stuck", 1.0)}
    NONE: ClassVar[Mapping[str, Any]] = {"dead": 0.0, "stuck": 0.0}

    def __post_init__(self) -> None:
        within("dead", self.dead, 0.0, 1.0)
        within("stuck", self.stuck, 0.0, 1.0 - self.dead)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with silent taxels."""
        lot, level = np.zeros(0), np.zeros(0)
        for batch in stream:
            if not lot.size:
                lot = random.uniform(size=batch.array.shape)
                level = random.uniform(-1, 1, (*batch.array.shape, 3)) * batch.full_scale
            dead, stuck = lot < self.dead, (lot >= self.dead) & (lot < self.dead + self.stuck)
            if not (dead.any() or stuck.any()):
                yield batch
                continue
            values = batch.values.copy()
            values[:, dead] = 0
            values[:, stuck] = level[stuck]
            yield replace(batch, values=values)
