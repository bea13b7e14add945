"""Adhesion: rubber sticks to what touches it, so that a contact can pull until it snaps off."""

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

import numpy as np

from tactile.simulator.altered import altered
from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field
from tactile.simulator.slopes import Slopes


@effect("field", assumed=False, price=(2, 0))
class Adhesion:
    """Spheres, needles and flat punches stick, with ``work`` [J/m^2] of adhesion.

    A sphere of radius R on the half-space is pulled off by 1.5 pi w R, whatever that is made of; at no force its
    contact is already cbrt(4.5 pi w R^2 / E*) wide. A contact is made where it touches (a push of 0 or more) and holds
    until it snaps off. Without this effect a body that is pulled has lifted off. Points, discs, edges, cylinders and
    height maps do not stick; slip is limited by friction times the force that the dry body would have at this radius.

    Source: Johnson, Kendall, Roberts (1971); about 0.05 J/m^2 for silicone rubber on a clean smooth body.
    """

    work: float = parameter(0.05, key="work_j_m2", none=0.0)
    sticks: ClassVar[bool] = True

    def most(self, slopes: Slopes) -> float:
        """Bound of the change: none of points, which do not stick; of bodies what a trial finds."""
        return 0.0 if slopes.at_points else math.inf

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields with what sticks."""
        for field in stream:
            yield altered(field, rig=altered(field.rig, work=self.work))
