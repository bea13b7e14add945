"""Bounds of how fast readings change from place to place, from what presses and how near the taxels are to it."""

import math
from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.compiled_loops import kept_njit
from tactile.core.frame import TaxelArray
from tactile.core.loads import COLUMNS, F
from tactile.elastic.halfspace import point_scale
from tactile.elastic.medium import Medium
from tactile.simulator.field import Field
from tactile.simulator.taxels import Taxels

ACROSS, DEEPER, BENT, LAPLACE = range(4)
STEEPEST = {"stress": (4.927, 6.0, 15.0, 30.0), "strain": (3.664, 4.0, 12.0, 24.0)}
"""Largest derivatives of a reading under a unit force at unit distance, whatever the directions of both: the first
across the surface and in depth, the second along one line and the Laplacian, both across the surface."""
VALUE = {"stress": 3.0, "strain": 2.0}
"""The largest reading itself, under the same force."""
BASE = 2.0
"""What a rigid base at the depth h adds is at most so many K |P| / h^2, for taxels at any depth above it and any
Poisson's ratio: the largest is the normal strain on the base itself of an incompressible cover (1.93 for stress)."""
FORCE, FIRST, SECOND = 0, 2, 3


@dataclass(frozen=True)
class Slopes:
    """How fast readings of the skin without effects change at most, over all frames of a finger.

    Under a point force P at the distance d a reading is homogeneous of degree -2 in place, so that its k-th derivatives
    are at most c_k |P| / d^(2 + k); c_k, in ``STEEPEST``, is the largest value over all directions of force and place.
    Fields add, and are smoother under loads that are spread, of which the nearest part counts.

    ``sums`` (4,): the largest over the frames of the sum over the loads of K |P| / d^n, n = 0, 2, 3, 4, with d to the
    nearest taxel and K = (c of the reading) / 2 pi; ``hardest`` [N]: the largest normal force; ``largest`` |reading|;
    ``at_points``: every contact is one point load; ``rises``: by how much [m] others than the effect that is asked
    raise the surface under contacts, with the tip's radius [m] of those at a point.

    Source: ``elastic.halfspace``, Boussinesq and Cerruti; the largest values by a search over all directions.
    """

    array: TaxelArray
    medium: Medium
    sums: Floats
    hardest: float
    largest: float
    at_points: bool
    rises: tuple[tuple[float, float], ...] = ()

    def pressed(self, hardest: float) -> "Slopes":
        """The same where the hardest normal force is another [N]."""
        return Slopes(self.array, self.medium, self.sums, hardest, self.largest, self.at_points, self.rises)

    def raised(self, rises: tuple[tuple[float, float], ...]) -> "Slopes":
        """The same where others raise the surface."""
        return Slopes(self.array, self.medium, self.sums, self.hardest, self.largest, self.at_points, rises)

    @property
    def reach(self) -> tuple[float, float]:
        """How far taxels lie from the array's centre at most, along x and y [m]."""
        array = self.array
        return (array.cols - 1) / 2 * array.pitch, (array.rows - 1) / 2 * array.pitch

    def across(self, by: float) -> float:
        """Bound of the change when taxels or loads move by so much [m] across the surface: the mean value theorem."""
        return by * self._most(ACROSS, FIRST) * self.nearer(by) ** 3

    def deeper(self, by: float) -> float:
        """Bound of the change under covers that are by so much [m] thicker or thinner; none for the whole depth."""
        depth = self.array.depth
        return by * self._most(DEEPER, FIRST) * (depth / (depth - by)) ** 3 if by < depth else math.inf

    def over_square(self, width: float) -> float:
        """Bound of the change when a square is averaged: w^2 / 24 of the second derivatives along both its sides."""
        return width**2 / 12 * self._most(BENT, SECOND) * self.nearer(width / math.sqrt(2)) ** 4

    def over_circle(self, radius: float) -> float:
        """Bound of the change when point loads are spread: <r^2> / 4 of the Laplacian, <r^2> at most 2/3 a^2.

        That of a flat punch: pressures under round tips lie nearer to the middle.
        """
        return radius**2 / 6 * self._most(LAPLACE, SECOND) * self.nearer(radius) ** 4

    def _most(self, kind: int, order: int) -> float:
        return STEEPEST[self.medium.quantity][kind] * float(self.sums[order])

    def over_base(self, thickness: float) -> float:
        """Bound of what a rigid base under a cover of this thickness adds to points' fields."""
        return BASE * float(self.sums[FORCE]) / thickness**2

    def nearer(self, by: float) -> float:
        """By what a distance may fall at most when the distance across falls by so much: d / d', largest over d."""
        t = by / self.array.depth
        return math.sqrt(1 + (t * t + t * math.sqrt(t * t + 4)) / 2)


class NearLoads:
    """The largest sums over loads of |P| and |P| / d^2, d^3, d^4, gathered field by field."""

    def __init__(self, taxels: Taxels) -> None:
        self.most, self.hardest, self.at_points = np.zeros(4), 0.0, True
        self._at = taxels.places.reshape(-1, 2), taxels.depth

    def add(self, field: Field) -> None:
        """Count the loads of a field without effects."""
        loads = field.loads
        sums = np.zeros((len(field.times), 4))
        points = loads.with_patterns
        if points.shape[1]:
            add_near(np.ascontiguousarray(points), np.zeros((1, 0)), *self._at, sums)
        for disc in loads.discs:
            add_near(np.ascontiguousarray(disc.loads), np.ascontiguousarray(disc.radii), *self._at, sums)
        for twist in loads.twists:  # its tractions add up to pi M W(0) / 2, on the half-space to 3 pi M / 8 a
            rows = np.zeros((*twist.radii.shape, COLUMNS))
            rows[..., :2] = twist.twists[..., :2]
            wide = np.where(twist.radii > 0, twist.radii, 1.0)
            middle = twist.profile.weight(np.zeros_like(wide), wide / twist.unit)
            rows[..., F] = np.where(twist.radii > 0, np.pi / 2 * middle * twist.twists[..., 2] / wide, 0.0)
            add_near(rows, np.ascontiguousarray(twist.radii), *self._at, sums)
        self.most = np.maximum(self.most, sums.max(axis=0))
        self.hardest = max(self.hardest, float(loads.totals[..., F].max(initial=0.0)))
        self.at_points = self.at_points and field.at_points

    def slopes(self, array: TaxelArray, medium: Medium, largest: float) -> Slopes:
        """What follows from them for the readings of a finger."""
        scale = point_scale(array.depth, medium)[0] * array.depth**2
        return Slopes(array, medium, scale * self.most, self.hardest, largest, self.at_points)


@kept_njit()
def add_near(rows, radii, places, depth, out):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Add the sums of loads (frames, n, 5) to ``out`` (frames, 4); ``radii`` (frames, n), or none of points."""
    nearest = np.empty(rows.shape[1])
    for n in range(rows.shape[0]):
        for m in range(rows.shape[1]):
            force = math.sqrt(rows[n, m, 2] ** 2 + rows[n, m, 3] ** 2 + rows[n, m, 4] ** 2)
            if n == 0 or rows[n, m, 0] != rows[n - 1, m, 0] or rows[n, m, 1] != rows[n - 1, m, 1]:
                best = np.inf
                for i in range(len(places)):
                    best = min(best, (places[i, 0] - rows[n, m, 0]) ** 2 + (places[i, 1] - rows[n, m, 1]) ** 2)
                nearest[m] = math.sqrt(best)
            aside = nearest[m] if radii.shape[1] == 0 else max(nearest[m] - radii[n, m], 0.0)
            square = aside * aside + depth * depth
            distance = math.sqrt(square)
            out[n, 0] += force
            out[n, 1] += force / square
            out[n, 2] += force / (square * distance)
            out[n, 3] += force / (square * square)
