"""A run on frames that never were, so that nothing is compiled or refused once real ones arrive."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.core.frame import Frame, TaxelArray
from tactile.finger import Settings
from tactile.pipeline import Sink, run

FRAMES = 2


class _Made:
    title, frames = "made up", None

    def __init__(self, arrays: tuple[TaxelArray, ...], modulus: float | None) -> None:
        self.arrays, self.modulus = arrays, modulus

    def __iter__(self) -> Iterator[Frame]:
        for finger, array in enumerate(self.arrays):
            for n in range(FRAMES):
                yield Frame(finger, 0.0, n, np.full((*array.shape, 3), 0.01), np.ones(array.shape, bool))


def warm_up(
    arrays: tuple[TaxelArray, ...], modulus: float | None, settings: Settings, sinks: Iterable[Sink] = ()
) -> None:
    """Run the pipeline with these settings on a made-up firm touch of every array."""
    run(_Made(arrays, modulus), replace(settings, tare=0), sinks)
