"""Memory bandwidth of this machine, measured by the triad a = b + s*c."""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from tests.benchmarks.race import race


def _stream(a: NDArray[np.float32], b: NDArray[np.float32], c: NDArray[np.float32], s: np.float32) -> None:
    for i in prange(a.size):
        a[i] = b[i] + s * c[i]


_triad = njit(parallel=True, error_model="numpy")(_stream)


def triad_rate(rounds: int = 5) -> float:
    """Return the bandwidth [1e9 bytes/s] on all cores, 12 bytes an element."""
    a, b, c = (np.ones(20_000_000, np.float32) for _ in range(3))
    return 12e-9 * a.size / race({"triad": lambda: _triad(a, b, c, np.float32(0.5))}, rounds)["triad"]
