"""Taxel area: a taxel feels the mean over its area."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.elastic.gauss import gauss
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field, field_at

MOST = 40


@effect("field")
class TaxelArea:
    """Square taxels ``width`` [m] wide that average over their area; 0 for points.

    Adds the mean over Gauss points (as many as the width over the depth asks for, error below 1e-6) minus the value
    in the middle, both of the half-space: what the tip and the layer add is smooth over a taxel.

    Source: Vasarhelyi, Fodor, Roska, sect. 2 (300 um) and 4.1.
    """

    width: float = parameter(300e-6, key="width_um", unit=1e-6, none=0.0)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields as areas feel them."""
        for field in stream:
            at, depth = field.array.positions(), field.array.depth
            # Gauss converges like exp(-2 n asinh(z / half width)): 7 is half of ln(1e6)
            count = min(MOST, int(np.ceil(7 / np.arcsinh(2 * depth / self.width))) + 1)
            nodes, weights = gauss(count)
            steps = np.stack(np.meshgrid(nodes, nodes), axis=-1).reshape(-1, 2) * self.width / 2
            over = np.outer(weights, weights).ravel() / 4
            everywhere = field_at(at[:, :, None] + steps, depth, field.loads, field.medium)
            term = np.einsum("nrcpk,p->nrck", everywhere, over) - field_at(at, depth, field.loads, field.medium)
            yield replace(field, values=field.values + term)
