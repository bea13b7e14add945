"""Equivalent point loads: fewer loads than cells, with the same field at the depth of the taxels."""

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import COLUMNS, PLACE, Q
from tactile.elastic.halfspace import point_load
from tactile.elastic.medium import Medium

WIDEST, STEP = 0.45, 0.85
"""Spacing of the first grid in depths, and its factor from one grid to the next."""
FEWER = 0.7
"""Largest share of the given loads that is worth replacing them."""
MOST = 1500
"""Most loads: solving for more takes longer than summing the cells."""
REGULAR = 1e-12
"""Added to the kernel's diagonal, so that forces of neighbours that taxels cannot tell apart stay small."""


def equivalent_points(places: Floats, shares: Floats, depth: float, accuracy: float) -> tuple[Floats, Floats]:
    """Return places (m, 2) [m] and shares (levels, m) of fewer loads, or those given where that needs too many.

    The loads lie on an even grid. Their shares minimise the difference of the potentials at the depth z, in the mean
    square over sources at that depth, whose kernel is (r^2 + 4 z^2)^(-3/2). The grid gets finer until the strain at the
    depth differs by less than half of ``accuracy`` times its peak.

    Arguments: ``places`` (n, 2) [m]; ``shares`` (levels, n), each level's sum 1; ``depth`` z [m] of the taxels.
    """
    low, high = places.min(axis=0), places.max(axis=0)
    tested = _grid(low - depth, high + depth, depth / 2)
    some = shares[[len(shares) // 2, -1]]
    exact = _strain(tested, places, some, depth)
    apart = WIDEST * depth
    while True:
        grid = _grid(low, high, apart)
        near = np.full(len(grid), np.inf)
        for part in np.array_split(places, 1 + len(places) * len(grid) // 1_000_000):
            near = np.minimum(near, _squares(grid, part).min(axis=1))
        grid = grid[near < apart**2]
        if len(grid) > min(FEWER * len(places), MOST):
            return places, shares
        kernel = _kernel(grid, grid, depth) + REGULAR * np.eye(len(grid))
        found = np.asarray(np.linalg.solve(kernel, _kernel(grid, places, depth) @ shares.T).T, dtype=np.float64)
        found /= found.sum(axis=1, keepdims=True)
        got = _strain(tested, grid, found[[len(shares) // 2, -1]], depth)
        if np.abs(got - exact).max() <= accuracy / 2 * np.abs(exact).max():
            return grid, found
        apart *= STEP


def _grid(low: Floats, high: Floats, apart: float) -> Floats:
    x, y = (
        (a + b) / 2 + (np.arange(n) - (n - 1) / 2) * apart
        for a, b, n in zip(low, high, np.ceil((high - low) / apart).astype(int) + 1, strict=True)
    )
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _squares(one: Floats, other: Floats) -> Floats:
    out: Floats = (one[:, None, 0] - other[:, 0]) ** 2 + (one[:, None, 1] - other[:, 1]) ** 2
    return out


def _kernel(one: Floats, other: Floats, depth: float) -> Floats:
    return (1 + _squares(one, other) / (4 * depth**2)) ** -1.5


def _strain(at: Floats, places: Floats, shares: Floats, depth: float) -> Floats:
    """Strain (levels, n, 3) at places ``at`` under loads with equal components along x, y and z."""
    rows = np.empty((len(shares), 1, len(places), COLUMNS))
    rows[..., PLACE] = places
    rows[..., Q:] = shares[:, None, :, None]
    return point_load(at, depth, rows, Medium(1.0))
