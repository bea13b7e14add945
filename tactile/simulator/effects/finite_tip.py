"""Finite tip: the hemisphere at the needle's end spreads the load over a circle."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.core.loads import F
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class FiniteTip:
    """Point loads are pressed by a rigid hemisphere of ``radius`` [m]; 0 leaves them points.

    Every contact that acts at one point is spread like the pressure under the tip. Contacts with a shape of their own
    stay as they are.

    Source: Sneddon (1965); Vasarhelyi, Fodor, Roska, sects 4 and 4.1 (a needle of 100 um).
    """

    radius: float = parameter(50e-6, key="radius_um", unit=1e-6, none=0.0)

    def most(self, field: Field) -> float:
        """Bound of the change over the largest reading: of the square of the contact's radius, Hertz' at most.

        Half as much again as any of some thousand draws of forces and places over four taxels.
        """
        forces = field.loads.totals[..., F].max(initial=0)
        widest = min(self.radius, float(np.cbrt(0.75 * forces * self.radius / field.medium.modulus)))
        return 9.0 * (widest / field.array.depth) ** 2

    def saves(self, field: Field) -> float:
        """Share of a frame's time: points are summed faster; where there are none, nothing."""
        return 0.3 if field.loads.points.shape[1] else 0.0

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields under tips."""
        for field in stream:
            yield replace(field, rig=replace(field.rig, tip=self.radius))
