"""Taxel area: readings are means over the area of a taxel."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class TaxelArea:
    """Square taxels ``width`` [m] wide that average over their area; 0 for points.

    The mean of the field over Gauss points; their number follows from the width over the depth and the accuracy.

    Source: Vasarhelyi, Fodor, Roska, sect. 2 (300 um) and 4.1.
    """

    width: float = parameter(300e-6, key="width_um", unit=1e-6, none=0.0)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields of taxels with an area."""
        for field in stream:
            yield replace(field, taxels=replace(field.taxels, width=self.width))
