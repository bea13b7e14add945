"""Fewer point loads that taxels at a depth cannot tell from many: for pressures on cells smaller than they need."""

import numpy as np

from cnnsim.support import Floats
from tactile.core.loads import COLUMNS, PLACE, Q
from tactile.elastic.halfspace import point_load
from tactile.elastic.medium import Medium

ACCURACY = 5e-4
"""Of the peak, to which a field stays what it is."""
WIDEST, STEP = 0.4, 0.8
"""Depths between the loads at first, and by what it is shortened until they do."""
WORTH = 0.7
"""Share of the loads from which fewer are not worth it."""
RIDGE = 1e-11
"""What keeps the forces small where loads lie so near each other that taxels cannot tell them apart."""
MOST = 1500
"""Loads at most, for the time that their forces take."""


def fewer_points(places: Floats, forces: Floats, depth: float, medium: Medium) -> tuple[Floats, Floats]:
    """Places (m, 2) [m] and forces (levels, m) [N] in place of those given: all of them where fewer will not do.

    On an even grid about the places, its forces chosen so that the fields of all loads of one size at a depth z differ
    least from what they stand for: those of a source at depth z seen from a source at depth z, (r^2 + 4 z^2)^(-3/2).

    Arguments: ``places`` (n, 2) [m], ``forces`` (levels, n) [N], ``depth`` z [m] of the taxels, ``medium`` they feel.
    """
    low, high = places.min(axis=0), places.max(axis=0)
    apart = WIDEST * depth
    tried = _grid(low - depth, high + depth, depth / 2)
    spread = forces[[len(forces) // 2, -1]]
    wanted = _felt(tried, places, spread, depth, medium)
    while True:
        grid = _grid(low, high, apart)
        near = np.full(len(grid), np.inf)
        for part in np.array_split(places, 1 + len(places) * len(grid) // 1_000_000):
            near = np.minimum(near, _squares(grid, part).min(axis=1))
        grid = grid[near < apart**2]
        if len(grid) > min(WORTH * len(places), MOST):
            return places, forces
        kernel = _nearness(grid, grid, depth) + RIDGE * np.eye(len(grid))
        made = np.asarray(np.linalg.solve(kernel, _nearness(grid, places, depth) @ forces.T).T, dtype=np.float64)
        got = _felt(tried, grid, made[[len(forces) // 2, -1]], depth, medium)
        if np.abs(got - wanted).max() <= ACCURACY * np.abs(wanted).max():
            return grid, made
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


def _nearness(one: Floats, other: Floats, depth: float) -> Floats:
    return (1 + _squares(one, other) / (4 * depth**2)) ** -1.5


def _felt(at: Floats, places: Floats, forces: Floats, depth: float, medium: Medium) -> Floats:
    """What places (n, 2) feel of forces (levels, m) that pull as they press, in the half-space: (levels, n, 3)."""
    rows = np.empty((len(forces), 1, len(places), COLUMNS))
    rows[..., PLACE] = places
    rows[..., Q:] = forces[:, None, :, None]
    return point_load(at, depth, rows, medium)
