"""Adhesion: a contact with rubber carries a pull until it snaps off."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.effect import effect, parameter
from tactile.simulator.field import Field


@effect("field")
class Adhesion:
    """Spheres, needles and flat punches stick, with ``work`` [J/m^2] of adhesion.

    A sphere of radius R on the half-space is pulled off by 1.5 pi w R for any modulus; without a force the radius of
    its contact is cbrt(4.5 pi w R^2 / E*). A contact is made by a push of 0 or more and holds until it snaps off.
    Without this effect a body that is pulled lifts off. Points, discs, edges, cylinders and height maps do not stick;
    slip is limited by friction times the force of the dry body with this radius.

    Source: Johnson, Kendall, Roberts (1971); about 0.05 J/m^2 for silicone rubber on a clean smooth body.
    """

    work: float = parameter(0.05, key="work_j_m2", none=0.0)

    def __call__(self, stream: Iterable[Field], random: np.random.Generator) -> Iterator[Field]:
        """Fields with adhesion."""
        for field in stream:
            yield replace(field, rig=replace(field.rig, work=self.work))
