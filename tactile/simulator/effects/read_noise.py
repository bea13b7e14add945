"""Read noise: white noise of the electronics."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.checks import within
from tactile.simulator.gaussian import GaussianNoise


@dataclass(frozen=True)
class ReadNoise:
    """Adds normal noise of standard deviation ``rms`` (of full scale) to every reading.

    Statistics: mean 0, independent between readings, channels and frames; normal as ``GaussianNoise`` declares.
    """

    rms: float = 0.002

    STAGE: ClassVar[str] = "frames"
    RANDOM: ClassVar[bool] = True
    KEYS: ClassVar[Mapping[str, tuple[str, float]]] = {"rms": ("rms", 1.0)}
    NONE: ClassVar[Mapping[str, Any]] = {"rms": 0.0}

    def __post_init__(self) -> None:
        within("rms", self.rms)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Noisy frames; the noise is added in place, for it must be no slower than the field."""
        if self.rms == 0:
            yield from stream
            return
        noise = GaussianNoise(random)
        for batch in stream:
            noise.add(batch.values, self.rms * batch.full_scale)
            yield batch
