"""Quantisation: steps and range of the analogue-to-digital converter."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames")
class Quantisation:
    """Readings become whole numbers of steps of 2 ``span`` / 2^``bits`` of full scale.

    The numbers go from -2^(bits-1) to 2^(bits-1) - 1. Inside the range the error is at most half a step (uniform for
    a busy signal, mean square step^2 / 12); beyond it the reading saturates. ``bits`` = 0 is no converter.
    """

    bits: int = parameter(12, 0, 48, none=0)
    span: float = parameter(1.5, 1e-12)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Quantised frames."""
        for batch in stream:
            half = 2.0 ** (self.bits - 1)
            step = self.span * batch.full_scale / half
            yield replace(batch, values=np.clip(np.rint(batch.values / step), -half, half - 1) * step)
