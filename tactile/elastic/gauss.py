"""Gauss-Legendre quadrature: nodes and weights on -1 .. 1, and on even panels."""

from functools import lru_cache

import numpy as np

from cnnsim.support import Floats


@lru_cache(maxsize=256)
def gauss(count: int) -> tuple[Floats, Floats]:
    """Return nodes and weights (count,) of the rule on -1 .. 1, read-only."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights


def panels(top: float, count: int) -> tuple[Floats, Floats]:
    """Return nodes and weights (16 count,) on 0 .. ``top``: 16 Gauss points in each of ``count`` even panels."""
    nodes, weights = gauss(16)
    edges = np.linspace(0, top, count + 1)
    at = ((edges[:-1] + edges[1:]) / 2)[:, None] + (edges[1] / 2) * nodes
    return at.ravel(), np.tile(weights * edges[1] / 2, count)
