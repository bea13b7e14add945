"""Finite tip: the hemisphere at the needle's end spreads the load over a circle."""

from collections.abc import Iterable, Iterator
from typing import ClassVar

import numpy as np

from tactile.simulator.altered import altered
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field
from tactile.simulator.slopes import Slopes


@effect("field", price=(140, 9.5))
class FiniteTip:
    """Point loads are pressed by a rigid hemisphere of ``radius`` [m]; 0 leaves them points.

    Every contact that acts at one point is spread like the pressure under the tip, on the cover as it is. Contacts with
    a shape of their own stay as they are.

    Source: Sneddon (1965); Vasarhelyi, Fodor, Roska, sects 4 and 4.1 (a needle of 100 um).
    """

    radius: float = parameter(50e-6, key="radius_um", unit=1e-6, none=0.0)

    smooths: ClassVar[bool] = True

    def most(self, slopes: Slopes) -> float:
        """Bound of the change under the widest contact: Hertz' at most, whatever nu, and no wider than the tip."""
        widest = (0.75 * slopes.hardest * self.radius / slopes.medium.modulus) ** (1 / 3)
        return slopes.over_circle(min(self.radius, widest))

    def saves(self, points: bool, layered: bool) -> float:
        """Share of a frame's time: points are summed faster; nothing where there are none, or by tables of a layer."""
        return 0.3 if points and not layered else 0.0

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields under tips."""
        for field in stream:
            yield altered(field, rig=altered(field.rig, tip=self.radius))
