"""Needle vibration: random displacement of the contacts in every frame."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field", random=True)
class NeedleVibration:
    """In every frame all contacts of a finger are displaced together, x and y by ``lateral``, z by ``vertical`` [m].

    Statistics: the displacements are independent from frame to frame (vibration is faster than the frames), normal,
    of mean 0 and of these standard deviations. The height z changes the force of each contact by its own law of force
    and indentation delta on the cover: on the half-space (1 + z / delta)^1.5 for a sphere, 1 + z / delta for a flat
    end, Sneddon's law for a needle; ``lines.line_indentation`` for a cylinder and for an edge of this ``tip_radius``
    [m]; ``layer_contact`` on a layer. A point load has the law of a sphere of ``tip_radius``. "A few microns of
    dislocation in the loading needle causes huge changes in the force".

    Source: Vasarhelyi, Fodor, Roska, sect. 4.1.
    """

    lateral: float = parameter(1e-6, key="lateral_um", unit=1e-6, none=0.0)
    vertical: float = parameter(0.5e-6, key="vertical_um", unit=1e-6, none=0.0)
    tip_radius: float = parameter(50e-6, 1e-12, key="tip_radius_um", unit=1e-6)

    @property
    def highest(self) -> tuple[float, float]:
        """Six standard deviations of the displacement across and in height [m]."""
        return 6 * self.lateral, 6 * self.vertical

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields with the contacts displaced."""
        for field in stream:
            moves = random.standard_normal((len(field.times), 3)) * (self.lateral, self.lateral, self.vertical)
            yield replace(field, rig=field.rig.with_move(partial(_moved, moves), self.tip_radius))


def _moved(moves: Floats, _places: Floats) -> tuple[Floats, Floats]:
    return moves[:, :2], moves[:, 2]
