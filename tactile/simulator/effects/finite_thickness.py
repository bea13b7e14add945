"""Finite thickness: the cover is an elastic layer bonded to the rigid chip."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.core.frame import TaxelArray
from tactile.simulator.altered import altered
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field
from tactile.simulator.slopes import Slopes


@effect("field", price=(60, 8.5))
class FiniteThickness:
    """The cover is a layer ``thickness`` [m] thick, infinite for the half-space; None: twice the taxels' depth.

    On the very bottom nothing can stretch sideways, so an incompressible cover has no normal strain there at all, only
    normal stress and shear.

    Every load, at a point or spread over a circle, and every twist is that on the layer, and every taxel's area feels
    it; where a cell of a traction map is as wide as the layer is deep, what the base adds is taken at its middle.

    Source: ``tactile.elastic.unit_disc``; Vasarhelyi, Fodor, Roska, sects 3 and 4.1.
    """

    thickness: float | None = parameter(None, 1e-12, key="thickness_mm", unit=1e-3, none=np.inf)

    def over(self, array: TaxelArray) -> float | None:
        """Return the thickness [m] of the cover over an array, None where it has no end, or cannot be."""
        thickness = 2 * array.depth if self.thickness is None else self.thickness
        return thickness if array.depth <= thickness < np.inf else None

    def most(self, slopes: Slopes) -> float:
        """Bound of the change, of points alone: what a body presses with depends on the layer as well."""
        return slopes.over_base(self._of(slopes)) if slopes.at_points else np.inf

    def _of(self, given: Field | Slopes) -> float:
        return 2 * given.array.depth if self.thickness is None else self.thickness

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields in the layer."""
        for field in stream:
            yield altered(field, medium=replace(field.medium, thickness=self._of(field)))
