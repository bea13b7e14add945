"""Quantisation: the steps of the analogue-to-digital converter, and the end of its range."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.checks import within


@dataclass(frozen=True)
class Quantisation:
    """Readings become whole numbers of steps of 2 ``span`` / 2^``bits`` of full scale.

    The numbers go from -2^(bits-1) to 2^(bits-1) - 1. Inside the range the error is at most half a step (uniform for
    a busy signal, mean square step^2 / 12); beyond it the reading saturates. ``bits`` = 0 is no converter."""

    bits: int = 12
    span: float = 1.5

    STAGE: ClassVar[str] = "frames"
    RANDOM: ClassVar[bool] = False
    KEYS: ClassVar[Mapping[str, tuple[str, float]]] = {"bits": ("bits", 1.0), "span": ("span", 1.0)}
    NONE: ClassVar[Mapping[str, Any]] = {"bits": 0}

    def __post_init__(self) -> None:
        within("bits", self.bits, 0, 48)
        within("span", self.span, 1e-12)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames in steps."""
        for batch in stream:
            if self.bits == 0:
                yield batch
                continue
            half = 2.0 ** (self.bits - 1)
            step = self.span * batch.full_scale / half
            yield replace(batch, values=np.clip(np.rint(batch.values / step), -half, half - 1) * step)
