"""Misplacement: the array is displaced, turned or tilted in its cover."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class Misplacement:
    """The array is displaced by (``shift_x``, ``shift_y``) [m], turned by ``turn`` [rad] and tilted.

    It turns about its centre from x to y, places and axes of the taxels alike; the nominal places of the array do not
    change. Tilts, the slopes of the array's plane along x and y, make the cover over a taxel thicker
    by ``tilt_x`` (x - x_c) + ``tilt_y`` (y - y_c), the chip being the base on which a finite cover lies. First order in
    the tilts: the axes stay upright.
    """

    shift_x: float = parameter(2e-5, -np.inf, key="shift_x_um", unit=1e-6, none=0.0)
    shift_y: float = parameter(2e-5, -np.inf, key="shift_y_um", unit=1e-6, none=0.0)
    turn: float = parameter(np.pi / 180, -np.pi, np.pi, key="turn_deg", unit=np.pi / 180, none=0.0)
    tilt_x: float = parameter(5e-3, -1.0, 1.0, none=0.0)
    tilt_y: float = parameter(0.0, -1.0, 1.0, none=0.0)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields at the taxels' true places."""
        for field in stream:
            apart = field.taxels.places - field.array.origin
            c, s = np.cos(self.turn), np.sin(self.turn)
            x, y = c * apart[..., 0] - s * apart[..., 1], s * apart[..., 0] + c * apart[..., 1]
            centre = np.add(field.array.origin, (self.shift_x, self.shift_y))
            taxels = replace(
                field.taxels, places=np.stack([x, y], axis=-1) + centre, turn=field.taxels.turn + self.turn
            )
            if self.tilt_x or self.tilt_y:
                taxels = taxels.raised(self.tilt_x * x + self.tilt_y * y)
            yield replace(field, taxels=taxels)
