"""What this machine can do at most: fused multiply-adds and memory traffic, measured."""

import numba
import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from tests.benchmarks.race import race

LANES, REPEATS = 256, 8_000_000


def _chain(total: NDArray[np.float32], c: np.float32, d: np.float32) -> None:
    for _ in range(REPEATS // 8):
        for j in range(LANES):
            v = total[j]
            v = v * c + d
            v = v * c + d
            v = v * c + d
            v = v * c + d
            v = v * c + d
            v = v * c + d
            v = v * c + d
            v = v * c + d
            total[j] = v


_one_core = njit(fastmath={"contract"}, error_model="numpy")(_chain)


def _all_cores(totals: NDArray[np.float32], c: np.float32, d: np.float32) -> None:
    for thread in prange(totals.shape[0]):
        _one_core(totals[thread], c, d)


def _stream(a: NDArray[np.float32], b: NDArray[np.float32], c: NDArray[np.float32], s: np.float32) -> None:
    for i in prange(a.size):
        a[i] = b[i] + s * c[i]


_multiply_add = njit(parallel=True, error_model="numpy")(_all_cores)
_triad = njit(parallel=True, error_model="numpy")(_stream)


def measure(rounds: int = 5) -> tuple[float, float]:
    """Return float32 FMA peak [1e9 flop/s] and triad bandwidth [1e9 bytes/s, 12 bytes an element], on all cores."""
    threads, half = numba.get_num_threads(), np.float32(0.5)
    room = np.zeros(threads * LANES + 16, np.float32)
    first = -room.ctypes.data % 64 // 4  # vectors across cache lines would wait for their own stores
    out = room[first : first + threads * LANES].reshape(threads, LANES)
    a, b, c = (np.ones(20_000_000, np.float32) for _ in range(3))
    best = race({"fma": lambda: _multiply_add(out, half, half), "triad": lambda: _triad(a, b, c, half)}, rounds)
    return 2e-9 * LANES * REPEATS * threads / best["fma"], 12e-9 * a.size / best["triad"]
