"""Finite tip: the hemisphere at the end of a needle spreads its load over a circle."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class FiniteTip:
    """Point loads are pressed by a rigid hemisphere of ``radius`` [m]; 0 leaves them points.

    Every contact at a point is spread like the pressure under the tip, on the half-space or layer. Contacts with a
    shape do not change.

    Source: Sneddon (1965); Vasarhelyi, Fodor, Roska, sects 4 and 4.1 (a needle of 100 um).
    """

    radius: float = parameter(50e-6, key="radius_um", unit=1e-6, none=0.0)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields under tips."""
        for field in stream:
            yield replace(field, rig=replace(field.rig, tip=self.radius))
