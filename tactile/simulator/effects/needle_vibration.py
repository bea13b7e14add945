"""Needle vibration: the needle's place and its height over the cover tremble."""

import math
from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.altered import altered
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field
from tactile.simulator.held_needle import raised
from tactile.simulator.seen import longest
from tactile.simulator.slopes import Slopes


@effect("field", normal=True, price=(45, 0.4))
class NeedleVibration:
    """Every frame all contacts of a finger are displaced together, x and y by ``lateral`` and z by ``vertical`` [m].

    Statistics: the displacements are independent from frame to frame (vibration is faster than the frames), normal,
    of mean 0 and of these standard deviations. The height z changes the force of each contact by its own law of force
    and indentation delta on the cover as it is: on the half-space (1 + z / delta)^1.5 for a sphere, 1 + z / delta for a
    flat end, Sneddon's law for a needle; a cylinder, and an edge of this ``tip_radius`` [m], go by
    ``lines.line_indentation``; on a layer all are stiffer, by ``layer_contact``. Loads at a point are held by a tip of
    ``tip_radius`` as by a sphere, under any force. "A few microns of dislocation in the loading needle causes huge
    changes in the force".

    Source: Vasarhelyi, Fodor, Roska, sect. 4.1.
    """

    lateral: float = parameter(1e-6, key="lateral_um", unit=1e-6, none=0.0)
    vertical: float = parameter(0.5e-6, key="vertical_um", unit=1e-6, none=0.0)
    tip_radius: float = parameter(50e-6, 1e-12, key="tip_radius_um", unit=1e-6)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields with the contacts where the rig has them."""
        for field in stream:
            moves = random.standard_normal((len(field.times), 3)) * (self.lateral, self.lateral, self.vertical)
            yield altered(field, rig=field.rig.with_move(partial(_moved, moves), self.tip_radius))

    def strays(self, field: Field, slopes: Slopes, frames: int) -> float:
        """Bound of the change in so many frames, for the frames of a field.

        A displacement is R deviations long at most, R of a normal vector in space. Of that a share c goes across and s
        upwards, c^2 + s^2 = 1, and as both changes A and B are convex the two together do at most c A(R) + s B(R).
        """
        aside = slopes.across(longest(frames) * self.lateral)
        if slopes.rises and aside:  # under contacts that others press harder
            aside *= 1 + raised(field, slopes.rises) / (slopes.largest or 1.0)
        return math.hypot(aside, raised(field, [(self.rises(frames), self.tip_radius)], slopes.rises))

    def rises(self, frames: int) -> float:
        """Bound of how far [m] it raises or lowers contacts in so many frames."""
        return longest(frames) * self.vertical


def _moved(moves: Floats, _places: Floats) -> tuple[Floats, Floats]:
    return moves[:, :2], moves[:, 2]
