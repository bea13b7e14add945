"""Cover error: deviation of the cover's thickness from its nominal value, with a gradient."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class CoverError:
    """The cover is thicker by ``error`` [m] over the array's centre, and by a gradient along x and y.

    Over a taxel at (x, y) from the centre it is thicker by error + ``gradient_x`` x + ``gradient_y`` y, and the taxel
    is deeper by this; the base of a finite cover stays on the chip. Each taxel is computed under an even cover of its
    own thickness: first order in the gradient.
    """

    error: float = parameter(2e-5, -np.inf, key="error_um", unit=1e-6, none=0.0)
    gradient_x: float = parameter(5e-3, -1.0, 1.0, key="gradient_x_um_per_mm", unit=1e-3, none=0.0)
    gradient_y: float = parameter(0.0, -1.0, 1.0, key="gradient_y_um_per_mm", unit=1e-3, none=0.0)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields under the uneven cover."""
        for field in stream:
            x, y = np.moveaxis(field.taxels.places - field.array.origin, -1, 0)
            thicker = self.error + self.gradient_x * x + self.gradient_y * y
            yield replace(field, taxels=field.taxels.raised(thicker))
