"""Needle vibration: the needle's place and its height over the cover tremble."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from cnnsim.support import Floats
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field
from tactile.simulator.held_needle import raised
from tactile.simulator.seen import sigmas

STEEPEST = 2.0
"""No reading changes faster across the surface than by so many times the largest one a depth: point loads 1 to 1.5."""


@effect("field", normal=True)
class NeedleVibration:
    """Every frame all contacts of a finger are displaced together, x and y by ``lateral`` and z by ``vertical`` [m].

    Statistics: the displacements are independent from frame to frame (vibration is faster than the frames), normal,
    of mean 0 and of these standard deviations. The height changes the force of each contact by its own law of force and
    indentation, (1 + z / delta)^1.5 for a sphere; loads at a point are held by a tip of ``tip_radius`` [m]: "a few
    microns of dislocation in the loading needle causes huge changes in the force".

    Source: Vasarhelyi, Fodor, Roska, sect. 4.1.
    """

    lateral: float = parameter(1e-6, key="lateral_um", unit=1e-6, none=0.0)
    vertical: float = parameter(0.5e-6, key="vertical_um", unit=1e-6, none=0.0)
    tip_radius: float = parameter(50e-6, 1e-12, key="tip_radius_um", unit=1e-6)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields with the contacts where the rig has them."""
        for field in stream:
            moves = random.standard_normal((len(field.times), 3)) * (self.lateral, self.lateral, self.vertical)
            yield replace(field, rig=field.rig.with_move(partial(_moved, moves), self.tip_radius))

    def strays(self, field: Field, frames: int) -> float:
        """Bound of the change in so many frames, for the frames of a field."""
        most = sigmas(frames)
        aside = STEEPEST * most * self.lateral / field.array.depth * float(np.abs(field.values).max(initial=0))
        return float(np.hypot(aside, raised(field, most * self.vertical, self.tip_radius)))


def _moved(moves: Floats, _places: Floats) -> tuple[Floats, Floats]:
    return moves[:, :2], moves[:, 2]
