"""Finite thickness: the cover is an elastic layer bonded to the rigid chip."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.elastic.layer_loads import layer_term
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class FiniteThickness:
    """The cover is a layer ``thickness`` [m] thick, infinite for the half-space; None: twice the taxels' depth.

    On the very bottom nothing can stretch sideways, so an incompressible cover has no normal strain there at all, only
    normal stress and shear.

    Adds layer minus half-space for all loads, those spread over circles taken at their centres (the layer's term
    is smooth on the scale of twice the thickness minus the depth). The layer's share of a twist is left out.

    Source: ``tactile.elastic.layer_loads``; Vasarhelyi, Fodor, Roska, sects 3 and 4.1.
    """

    thickness: float | None = parameter(None, 1e-12, key="thickness_mm", unit=1e-3, none=np.inf)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields in the layer."""
        for field in stream:
            thickness = 2 * field.array.depth if self.thickness is None else self.thickness
            loads = np.concatenate([field.loads.points, *(disc.loads for disc in field.loads.discs)], axis=1)
            term = layer_term(field.array.positions(), field.array.depth, loads[:, None, None], thickness, field.medium)
            yield replace(field, values=field.values + term)
