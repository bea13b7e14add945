"""Gauss-Legendre nodes and weights, made once for each count."""

from functools import lru_cache

import numpy as np

from cnnsim.support import Floats


@lru_cache(maxsize=256)
def gauss(count: int) -> tuple[Floats, Floats]:
    """Nodes and weights (count,) of the rule on -1 .. 1, not to be written to."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights
