"""Hard grids: one row, one column and one cell under every boundary."""

from typing import Any

import numpy as np

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, run_transient
from cnnsim.backends.base import Backend
from cnnsim.support import Array
from tests.hard_cases.case import HardCase
from tests.oracles.exact_transient import exact

A = np.array([[0.1, 0.2, 0.05], [0.15, 0.4, -0.3], [0.1, 0.05, 0.1]])


def _case(shape: tuple[int, int], boundary: Any) -> HardCase:
    x = np.random.default_rng(sum(shape)).uniform(-1, 1, shape)

    def ours(backend: Backend) -> Array:
        return run_transient(
            Template(A, z=0.1), state=x, boundary=boundary, duration=2.0, accuracy=1e-8, backend=backend
        ).x

    def naive() -> Array:
        """The boundary of zeros that a convolution has."""
        now = x.copy()
        for _ in range(2000):
            y = np.pad(now.clip(-1, 1), 1)
            drive = sum(A[k, l] * y[k : k + shape[0], l : l + shape[1]] for k in range(3) for l in range(3))
            now = now + 0.001 * (drive + 0.1 - now)
        return now

    return HardCase(
        f"{shape[0]} x {shape[1]}, {boundary}",
        "all cells are at the edge, and a virtual cell may repeat the cell itself",
        ours, lambda: exact(A, np.full(shape, 0.1), x, boundary, 2.0), 1e-8, 1e-8, naive,
    )  # fmt: skip


CASES = [
    _case(shape, boundary)
    for shape in ((1, 1), (1, 7), (7, 1))
    for boundary in (ZERO_FLUX, PERIODIC, fixed(0.5), fixed(-1))
]
