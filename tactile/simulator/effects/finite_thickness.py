"""Finite thickness: the cover is an elastic layer bonded to the rigid chip."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.core.frame import TaxelArray
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class FiniteThickness:
    """The cover is a layer ``thickness`` [m] thick, infinite for the half-space; None: twice the taxels' depth.

    On the base nothing can stretch sideways, so an incompressible cover has no normal strain there, only normal stress
    and shear.

    All loads and twists act on the layer. Under a cell of a traction map that is as wide as the layer is deep, what the
    base adds is computed at the cell's centre.

    Source: ``tactile.elastic.unit_disc``; Vasarhelyi, Fodor, Roska, sects 3 and 4.1.
    """

    thickness: float | None = parameter(None, 1e-12, key="thickness_mm", unit=1e-3, none=np.inf)

    def over(self, array: TaxelArray) -> float | None:
        """Return the thickness [m] of the cover over an array, None where it is infinite or less than the depth."""
        thickness = self._of(array)
        return thickness if array.depth <= thickness < np.inf else None

    def _of(self, array: TaxelArray) -> float:
        return 2 * array.depth if self.thickness is None else self.thickness

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields in the layer."""
        for field in stream:
            yield replace(field, medium=replace(field.medium, thickness=self._of(field.array)))
