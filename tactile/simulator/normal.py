"""Normal random numbers as fast as the field they are added to: a hash of a counter and a table of quantiles."""

from functools import lru_cache

import numpy as np
from numba import get_num_threads, njit, prange
from numpy.typing import NDArray

BITS = 13
"""The table has 2^13 quantiles: 32 KiB, the first-level cache."""
MASK = np.uint32((1 << BITS) - 1)


@lru_cache(maxsize=1)
def _quantiles() -> NDArray[np.float32]:
    """Means of the standard normal over bins of equal probability, scaled so that two of them add to variance 1."""
    from scipy.special import ndtri  # only where noise is called for

    edges = ndtri(np.linspace(0, 1, (1 << BITS) + 1))
    density = np.exp(-(edges**2) / 2) / np.sqrt(2 * np.pi)
    means = -np.diff(density) * (1 << BITS)
    scaled: NDArray[np.float32] = (means / np.sqrt((means**2).sum() * 2 / (1 << BITS))).astype(np.float32)
    return scaled


@njit(cache=True)
def _add(values, first, last, sigma, key, count, table):  # type: ignore[no-untyped-def]  # numba types it at the call
    for i in range(first, last):
        # lowbias32 of the counter, then of the key: every bit depends on every bit
        h = np.uint32(np.uint32(i) + count)  # numba widens every operation of 32 bits, hence the casts
        h = np.uint32((h ^ (h >> np.uint32(16))) * np.uint32(0x7FEB352D))
        h = np.uint32(h ^ (h >> np.uint32(15)) ^ key)
        h = np.uint32(h * np.uint32(0x846CA68B))
        h = np.uint32((h ^ (h >> np.uint32(16))) * np.uint32(0x7FEB352D))
        h = np.uint32(h ^ (h >> np.uint32(15)))
        values[i] += sigma * (np.float64(table[h & MASK]) + np.float64(table[(h >> np.uint32(16)) & MASK]))


@njit(cache=True, parallel=True)
def _add_parallel(values, threads, sigma, key, count, table):  # type: ignore[no-untyped-def]  # the same
    for thread in prange(threads):
        first, last = thread * values.size // threads, (thread + 1) * values.size // threads
        _add(values, first, last, sigma, key, count, table)


class NormalNoise:
    """A stream of independent standard normal numbers, the same however it is cut into pieces.

    Each is the sum of two quantiles of a table: the distribution function is within 1e-4 of the normal one, the
    variance 1 to 1e-6, and no number lies beyond 5.7. Numbers repeat after 2^32 of them, when a new key is drawn.

    Arguments: ``random``, from which only the keys are taken.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._count = 0
        self._key = self._draw()

    def _draw(self) -> np.uint32:
        return np.uint32(self._random.integers(1 << 32))

    def add(self, values: NDArray[np.float64], sigma: float) -> None:
        """Add the next ``values.size`` numbers times ``sigma`` to ``values`` (contiguous), in place."""
        flat = values.reshape(-1)
        assert np.shares_memory(flat, values) or not values.size  # a copy would be thrown away
        if self._count + flat.size > 1 << 32:
            self._count, self._key = 0, self._draw()
        numbers = np.float64(sigma), self._key, np.uint32(self._count), _quantiles()
        if flat.size < 20_000:
            _add(flat, 0, flat.size, *numbers)
        else:
            _add_parallel(flat, get_num_threads(), *numbers)
        self._count += flat.size
