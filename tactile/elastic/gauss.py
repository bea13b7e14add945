"""Gauss-Legendre nodes and weights, made once for each count."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray


@lru_cache(maxsize=256)
def gauss(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights (count,) of the rule on -1 .. 1, not to be written to."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights
