"""Poisson's ratio of the cover below 1/2: rubber is slightly compressible."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class PoissonRatio:
    """The cover's Poisson's ratio ``nu``; 1/2 is the paper's model and changes nothing.

    Stress in the half-space under the same tractions does not depend on nu; contact radii and indentations do, and so
    does the layer.

    Source: Johnson, Contact Mechanics, eqs (3.18), (3.75); Vasarhelyi, Fodor, Roska, sect. 4.1.
    """

    nu: float = parameter(0.49, 0.0, 0.5, none=0.5)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields in the compressible cover."""
        for field in stream:
            yield replace(field, medium=replace(field.medium, nu=self.nu))
