"""Curved fingertip: a dome over a flat chip, to first order in its curvature."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class CurvedFingertip:
    """The cover's surface is a dome of ``radius`` [m] whose crown lies over the array's centre; infinite for a plane.

    To first order in 1 / radius: at a distance r from the crown the cover is thinner by r^2 / (2 radius), and a sphere,
    needle or cylinder of radius R touches it like one of 1 / (1 / R + 1 / radius) a plane; a height map, like one that
    is higher by r^2 / (2 radius), r from its middle. Flat ends touch with all of their area, edges and cylinders with
    all of their length. The slope of the surface, r / radius, is neglected: loads stay upright.

    Source: Johnson, Contact Mechanics, eq. (4.17), for the radius.
    """

    radius: float = parameter(0.05, 1e-9, key="radius_mm", unit=1e-3, none=np.inf)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields under the dome."""
        for field in stream:
            apart = field.taxels.places - field.array.origin
            taxels = field.taxels.raised(-(apart**2).sum(axis=-1) / (2 * self.radius))
            yield replace(field, taxels=taxels, rig=replace(field.rig, curvature=1 / self.radius))
