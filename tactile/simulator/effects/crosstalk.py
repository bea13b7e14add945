"""Crosstalk between the channels of a taxel and with those of its neighbours."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames")
class Crosstalk:
    """Components gain ``cross_axis`` times the taxel's two others, then ``neighbour`` times the four neighbours'.

    Linear and without memory: y_c = x_c + cross_axis (x_a + x_b), then y += neighbour * sum of y over the neighbours
    to the north, south, west and east; outside the array y is 0.

    Source: cross-axis matrix and mechanical coupling as in Vasarhelyi, Fodor, Roska, sects 2 and 5.
    """

    cross_axis: float = parameter(0.01, -1.0, 1.0, none=0.0)
    neighbour: float = parameter(0.005, -1.0, 1.0, none=0.0)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Mixed frames."""
        for batch in stream:
            values = batch.values
            if self.cross_axis != 0:
                values = values + self.cross_axis * (values.sum(axis=-1, keepdims=True) - values)
            if self.neighbour != 0:
                around = np.zeros_like(values)
                around[:, 1:] += values[:, :-1]
                around[:, :-1] += values[:, 1:]
                around[:, :, 1:] += values[:, :, :-1]
                around[:, :, :-1] += values[:, :, 1:]
                values = values + self.neighbour * around
            yield replace(batch, values=values)
