"""Taxels of a finger: places, width, orientation, cover thickness, and their readings of a field."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.frame import SHEAR_X, SHEAR_Y, TaxelArray
from tactile.elastic.gauss import gauss
from tactile.elastic.medium import Medium

FINEST = 1e-7
"""Finest accuracy of means over the area of a taxel."""
MOST = 64
"""Largest number of Gauss points across a taxel."""
AT_ONCE = 256
"""Points that are computed in one call."""
DEPTHS = 12
"""Largest number of depths between which a field is interpolated."""

Reading = Callable[[Floats, float, Medium], Floats]
"""From points (..., 2), a depth and a medium to readings (frames, ..., 3)."""


@dataclass(frozen=True)
class TaxelLayout:
    """The taxels of one finger: ``places`` (rows, cols, 2) [m], ``depth`` [m].

    ``width`` [m] of square taxels that read the mean over their area, 0 for points; ``thicker`` (rows, cols) [m]:
    deviation of the cover's thickness over each, None for none; ``turn`` [rad] of their axes, x to y.
    """

    places: Floats
    depth: float
    width: float = 0.0
    thicker: Floats | None = None
    turn: float = 0.0

    @classmethod
    def of(cls, array: TaxelArray) -> "TaxelLayout":
        """Points at the places of an array; force taxels at the surface have their pitch as depth."""
        return cls(array.positions(), array.depth or array.pitch)

    def raised(self, thicker: Floats) -> "TaxelLayout":
        """The taxels under a cover that is thicker by another (rows, cols) [m]."""
        return replace(self, thicker=thicker if self.thicker is None else self.thicker + thicker)

    def measure(self, reading: Reading, medium: Medium, accuracy: float, at_once: bool = False) -> Floats:
        """The readings (frames, rows, cols, 3) with an error of about ``accuracy`` of the peak.

        ``at_once``: the reading takes any number of points in one call.
        """
        way = self._mean if self.thicker is None else self._levels
        values = way(reading, medium, accuracy, at_once)
        if self.turn:
            c, s = np.cos(self.turn), np.sin(self.turn)
            x, y = values[..., SHEAR_X].copy(), values[..., SHEAR_Y].copy()
            values[..., SHEAR_X], values[..., SHEAR_Y] = c * x + s * y, c * y - s * x
        return values

    def _levels(self, reading: Reading, medium: Medium, accuracy: float, at_once: bool) -> Floats:
        """Readings interpolated by a polynomial between a few thicknesses."""
        assert self.thicker is not None
        low, high = float(self.thicker.min()), float(self.thicker.max())
        if self.depth + low <= 0:
            raise InputError(
                f"a cover {-low * 1e3:.4g} mm thinner over taxels {self.depth * 1e3:g} mm deep; less than that wanted"
            )
        middle, half = (low + high) / 2, (high - low) / 2
        # a field is analytic down to the surface: Chebyshev points converge like (half / 2 depth)^n at worst
        count = 1
        if half > 1e-9 * self.depth:
            share = (self.depth + middle) / half
            count = min(DEPTHS, 2 + int(np.ceil(-np.log(max(accuracy, 1e-9)) / np.log(share + np.sqrt(share**2 - 1)))))
        nodes = middle + half * np.cos((np.arange(count) + 0.5) * np.pi / count)
        values = np.zeros(())
        for n, node in enumerate(nodes.tolist()):
            weight = np.ones(self.thicker.shape)
            for other in np.delete(nodes, n).tolist():
                weight *= (self.thicker - other) / (node - other)
            level = replace(self, depth=self.depth + node, thicker=None)  # its axes are turned at the end
            values = values + weight[..., None] * level._mean(
                reading, replace(medium, thickness=medium.thickness + node), accuracy, at_once
            )
        return values

    def _mean(self, reading: Reading, medium: Medium, accuracy: float, at_once: bool) -> Floats:
        if self.width == 0:
            return reading(self.places, self.depth, medium)
        nodes = list(self._nodes(accuracy))
        if at_once and len(nodes) * self.places[..., 0].size <= AT_ONCE:
            steps = np.array([step for step, _ in nodes])[:, None, None]
            values = reading(self.places + steps, self.depth, medium)
            return np.asarray(np.einsum("n,fn...->f...", [share for _, share in nodes], values))
        values = np.zeros(())
        for step, share in nodes:
            values = values + share * reading(self.places + step, self.depth, medium)
        return values

    def _nodes(self, accuracy: float) -> Iterator[tuple[Floats, float]]:
        nodes, weights = gauss(self._count(max(accuracy, FINEST)))
        c, s = np.cos(self.turn), np.sin(self.turn)
        for a, along in zip(nodes.tolist(), weights.tolist(), strict=True):
            for b, across in zip(nodes.tolist(), weights.tolist(), strict=True):
                yield np.array([c * a - s * b, s * a + c * b]) * self.width / 2, along * across / 4

    def _count(self, accuracy: float) -> int:
        # Gauss converges like 12 n exp(-2 n asinh(z / half width)): measured under points at their worst places,
        # relative to the peak over an array; a single taxel may lie right under a load along the surface, whose
        # reading is zero at its centre
        wide = self.width / self.depth
        rate = 2 * np.arcsinh(2 / wide)
        worst = 30 / min(1.0, wide) ** 2 if self.places[..., 0].size == 1 else 12.0
        for n in range(1, MOST + 1):
            if worst * n * np.exp(-n * rate) <= accuracy:
                return n
        raise InputError(
            f"taxels {self.width * 1e3:.4g} mm wide and {self.depth * 1e3:.4g} mm deep to {accuracy:g} of the peak; "
            f"{worst * MOST * np.exp(-MOST * rate):.2g} or more, or narrower ones, wanted"
        )
