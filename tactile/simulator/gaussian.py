"""Gaussian random numbers as fast as the field they are added to: a hash of a counter and a table of quantiles."""

from functools import lru_cache

import numpy as np
from numba import get_num_threads, prange
from numpy.typing import NDArray

from cnnsim.support import Floats
from cnnsim.support.compiled_loops import kept_helper, kept_njit

BITS = 13
"""The table has 2^13 quantiles: 32 KiB, the first-level cache."""
LARGEST = 5.7
"""No number is larger."""
SERIAL_BELOW = 200_000
"""Fewer pairs than this are done before the threads have woken up, or soon after."""
BLOCK = 512
"""Pairs hashed at once."""
LONGEST = 1 << 33
"""Numbers from one key."""
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


@kept_helper()
def _hash(pair, key):  # type: ignore[no-untyped-def]  # numba types it at the call
    """lowbias32 of the counter, then of the key: every bit depends on every bit."""
    h = np.uint32(pair)  # numba widens every operation of 32 bits, hence the casts
    h = np.uint32((h ^ (h >> np.uint32(16))) * np.uint32(0x7FEB352D))
    h = np.uint32(h ^ (h >> np.uint32(15)) ^ key)
    h = np.uint32(h * np.uint32(0x846CA68B))
    h = np.uint32((h ^ (h >> np.uint32(16))) * np.uint32(0x7FEB352D))
    return np.uint32(h ^ (h >> np.uint32(15)))


@kept_njit()
def _add_pairs(pairs, first, last, sigma, key, count, table):  # type: ignore[no-untyped-def]  # the same
    """Add to rows first .. last of (n, 2): a + b and a - b of two normal numbers are two, independent.

    Hashes first, in vectors; then the look-ups, one by one: gathered in vectors they are half as fast.
    """
    hashes = np.empty(BLOCK, np.uint32)
    for start in range(first, last, BLOCK):
        size = min(BLOCK, last - start)
        for i in range(size):
            hashes[i] = _hash(np.uint32(start + i) + count, key)
        for i in range(size):
            h = hashes[i]
            a, b = sigma * table[h & MASK], sigma * table[(h >> np.uint32(16)) & MASK]
            pairs[start + i, 0] += a + b
            pairs[start + i, 1] += a - b


@kept_njit(parallel=True)
def _add_parallel(pairs, threads, sigma, key, count, table):  # type: ignore[no-untyped-def]  # the same
    for thread in prange(threads):
        first, last = thread * len(pairs) // threads, (thread + 1) * len(pairs) // threads
        _add_pairs(pairs, first, last, sigma, key, count, table)


class GaussianNoise:
    """A stream of independent standard normal numbers, the same however it is cut into pieces.

    Two of them are sum and difference of two quantiles of a table: the distribution function is within 1e-4 of the
    normal one, the variance 1 to 1e-6, and no number lies beyond 5.7. After 2^33 numbers a new key is drawn.

    Arguments: ``random``, from which only the keys are taken.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._count = 0
        self._key = self._draw()

    def _draw(self) -> np.uint32:
        return np.uint32(self._random.integers(1 << 32))

    def add(self, values: Floats, sigma: float) -> None:
        """Add the next ``values.size`` numbers times ``sigma`` to ``values`` (contiguous), in place."""
        flat = values.reshape(-1)
        assert np.shares_memory(flat, values) or not values.size  # a copy would be thrown away
        left = LONGEST - self._count
        if flat.size > left:  # at the same number however the stream is cut
            self.add(flat[:left], sigma)
            self._count, self._key = 0, self._draw()
            self.add(flat[left:], sigma)
            return
        start = 0
        if self._count % 2 and flat.size:  # the second of a pair whose first was the last number of the piece before
            flat[0] += self._pair(sigma)[1]
            start = 1
        whole = (flat.size - start) // 2
        pairs = flat[start : start + 2 * whole].reshape(-1, 2)
        numbers = np.float64(sigma), self._key, np.uint32((self._count + start) // 2), _quantiles()
        if whole < SERIAL_BELOW:
            _add_pairs(pairs, 0, whole, *numbers)
        else:
            _add_parallel(pairs, get_num_threads(), *numbers)
        self._count += start + 2 * whole
        if start + 2 * whole < flat.size:
            flat[-1] += self._pair(sigma)[0]
            self._count += 1

    def _pair(self, sigma: float) -> Floats:
        """The pair that the next number belongs to."""
        pair = np.zeros((1, 2))
        _add_pairs(pair, 0, 1, np.float64(sigma), self._key, np.uint32(self._count // 2), _quantiles())
        return pair[0]
