"""Nearest-neighbour classification of materials: the feature space, and the vote of the nearest known windows."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cnnsim.support import Flags, Floats, Integers

NEIGHBOURS = 31
"""Number of known windows that vote, with weight 1 / distance; neighbouring windows overlap."""
SAME = 1e-6
"""Distance below which two windows are identical up to rounding; known windows of a material are about 1 apart."""
NOVEL = 5
"""Rank (from 0) of the known window whose distance is the novelty."""


@dataclass(frozen=True)
class Space:
    """The feature space: features scaled, extended by kernels, and projected to discriminants.

        u = (features - centre) / scale,   v = (u, weight * K(u) root),   place = v projection
        K_j = exp(-gamma |u - landmark_j|^2)

    ``landmarks`` (m, k) and ``root`` (m, m) may be empty; ``projection`` (k + m, d).

    Source: Williams, Seeger, Using the Nystroem method to speed up kernel machines (2001), for the kernels.
    """

    centre: Floats
    scale: Floats
    landmarks: Floats
    root: Floats
    gamma: float
    weight: float
    projection: Floats

    def __call__(self, values: Floats) -> Floats:
        """Return the positions (n, d) of features (n, k)."""
        place: Floats = self.joined((values - self.centre) / self.scale) @ self.projection
        return place

    def joined(self, scaled: Floats) -> Floats:
        """Return scaled features (n, k) with their kernels (n, k + m)."""
        if not len(self.landmarks):
            return scaled
        square = (scaled**2).sum(1)[:, None] + (self.landmarks**2).sum(1) - 2 * scaled @ self.landmarks.T
        return np.hstack([scaled, self.weight * np.exp(-self.gamma * np.maximum(square, 0)) @ self.root.T])


class Vote(NamedTuple):
    """Votes on windows (n,): ``shares`` (n, materials), and ``novelty`` (n,), a distance in the space."""

    shares: Floats
    novelty: Floats

    @property
    def material(self) -> Integers:
        """(n,) number of the material with the largest share."""
        return self.shares.argmax(1)

    @property
    def share(self) -> Floats:
        """(n,) largest share of the votes."""
        return self.shares.max(1)


@dataclass(frozen=True)
class KnownWindows:
    """Windows of known material: ``places`` (m, d) and ``material`` (m,), numbers below ``count``."""

    places: Floats
    material: Integers
    count: int

    def holds(self, places: Floats) -> Flags:
        """Return which positions (n, d) are those of a known window."""
        from scipy.spatial import cKDTree  # slow to import

        distance, _ = cKDTree(self.places).query(places)
        same: Flags = distance < SAME
        return same

    def vote(self, places: Floats) -> Vote:
        """Return the votes of the nearest known windows on positions (n, d)."""
        from scipy.spatial import cKDTree  # slow to import

        ranks = min(NEIGHBOURS, len(self.places))
        distance, nearest = cKDTree(self.places).query(places, np.arange(1, ranks + 1))
        weight = 1 / np.maximum(distance, 1e-9)
        votes = np.zeros((len(places), self.count))
        np.add.at(votes, (np.arange(len(places))[:, None], self.material[nearest]), weight)
        votes /= votes.sum(1, keepdims=True)
        return Vote(votes, distance[:, min(NOVEL, ranks - 1)])
