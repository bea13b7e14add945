"""Taxel mismatch: random gain, zero and ratio of shear to normal of each taxel."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.core.frame import NORMAL
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames", random=True)
class TaxelMismatch:
    """A taxel reads (1 + g) x + o in its normal component and (1 + g) (1 + b) x + o in its shears.

    Statistics: g and b, the mismatch of its gain and of its beta_ns, are drawn once per taxel, o once per channel;
    normal, independent, of mean 0 and standard deviations ``gain``, ``beta_ns`` and ``offset`` (of full scale).

    Source: Vasarhelyi, Fodor, Roska, eqs (15), (16), and sect. 4 for the spread of beta_ns (1.46 +- 0.04).
    """

    gain: float = parameter(0.01, none=0.0)
    offset: float = parameter(0.002, none=0.0)
    beta_ns: float = parameter(0.02, none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with mismatch."""
        gain, offset = np.zeros(0), np.zeros(0)
        for batch in stream:
            if not gain.size:
                shape = batch.array.shape
                gain = np.repeat(1 + self.gain * random.standard_normal((*shape, 1)), 3, axis=-1)
                gain[..., :NORMAL] *= 1 + self.beta_ns * random.standard_normal((*shape, 1))
                offset = self.offset * batch.full_scale * random.standard_normal((*shape, 3))
            yield replace(batch, values=batch.values * gain + offset)
