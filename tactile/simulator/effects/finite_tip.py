"""Finite tip: the hemisphere at the needle's end spreads the load over a circle."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.core.loads import F
from tactile.elastic.discs import disc_load
from tactile.elastic.halfspace import point_load
from tactile.elastic.profiles import ROUND_TIP, round_tip_radius
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class FiniteTip:
    """Point loads are pressed by a rigid hemisphere of ``radius`` [m]; 0 leaves them points.

    Adds, for every contact that acts at one point, the field of its load spread like the pressure under the tip
    minus that of the point. Contacts with a shape of their own stay as they are.

    Source: Sneddon (1965); Vasarhelyi, Fodor, Roska, sects 4 and 4.1 (a needle of 100 um).
    """

    radius: float = parameter(50e-6, key="radius_um", unit=1e-6, none=0.0)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields under tips."""
        for field in stream:
            owner = field.loads.owner
            points = np.bincount(owner)[owner] == 1 if owner.size else np.zeros(0, bool)
            loads = field.loads.points[:, points][:, None, None]
            if not loads.size:
                yield field
                continue
            radii = round_tip_radius(loads[..., F], self.radius, field.medium.contact_modulus)
            at, depth = field.array.positions(), field.array.depth
            spread = disc_load(at, depth, loads, radii, ROUND_TIP, field.medium, radii / self.radius)
            yield replace(field, values=field.values + spread - point_load(at, depth, loads, field.medium))
