"""Graded triangulation of a plane region: points along its boundary, then circumcentres of triangles too large."""

from collections.abc import Callable

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from cnnsim.support import Flags, Floats, Integers

LARGEST = 0.75
"""Circumradius over wanted edge length above which a triangle gets a point; 0.58 is the equilateral triangle's."""

Side = Callable[[Floats], Floats]
"""Maps shares (n,) from 0 to 1 along a side of the boundary to points (n, 2)."""


def straight(start: tuple[float, float], stop: tuple[float, float]) -> Side:
    """Return the line between two points."""
    return lambda share: np.stack([a + (b - a) * share for a, b in zip(start, stop, strict=True)], axis=-1)


def triangulate(
    outline: list[Side], inside: Callable[[Floats], Flags], size: Callable[[Floats], Floats]
) -> tuple[Floats, Integers]:
    """Return points (n, 2) and triangles (m, 3) of the region within a closed outline.

    A new point lies at least its wanted edge length times 0.75 from all others, and so, with boundary points an edge
    length apart, at least half a length from the boundary: no triangle is thin. No corner of the region may be
    sharper than about 60 degrees.

    Arguments: ``outline``: sides that follow one another around the region, their ends its fixed points;
    ``inside``: which points lie in the open region; ``size``: wanted edge length at points.

    Source: Ruppert (1995), Delaunay refinement.
    """
    points = np.concatenate([_graded(line, size)[:-1] for line in outline])
    for _ in range(200):
        triangles = _triangles(points, inside)
        centre, radius = _circles(points, triangles)
        excess = radius / size(centre)
        new = np.flatnonzero((excess > LARGEST) & inside(centre))
        if not new.size:
            break
        new = new[np.argsort(-excess[new])]
        # of circumcentres too close to each other the worst is taken
        tree, taken = cKDTree(centre[new]), np.zeros(len(new), bool)
        for n, close in enumerate(tree.query_ball_point(centre[new], LARGEST * size(centre[new]))):
            taken[n] = not taken[close].any()
        points = np.concatenate([points, centre[new[taken]]])
    return points, triangles


def _graded(side: Side, size: Callable[[Floats], Floats]) -> Floats:
    """Return points on a side, each a wanted edge length from the next, with both ends."""
    share = np.linspace(0, 1, 9)
    while True:
        points, middle = side(share), side((share[1:] + share[:-1]) / 2)
        step = np.linalg.norm(np.diff(points, axis=0), axis=1) / size(middle)
        if not (step > 0.5).any():
            break
        share = np.sort(np.concatenate([share, ((share[1:] + share[:-1]) / 2)[step > 0.5]]))
    count = np.concatenate([[0.0], np.cumsum(step)])
    at = np.linspace(0, count[-1], max(2, int(np.ceil(count[-1])) + 1))
    return side(np.interp(at, count, share))


def _triangles(points: Floats, inside: Callable[[Floats], Flags]) -> Integers:
    triangles = Delaunay(points).simplices.astype(np.int64)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    longest = np.max([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)], axis=0)
    area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    return triangles[(area > 1e-6 * longest) & inside((a + b + c) / 3)]  # points on a line make flat triangles


def _circles(points: Floats, triangles: Integers) -> tuple[Floats, Floats]:
    a = points[triangles[:, 0]]
    b, c = points[triangles[:, 1]] - a, points[triangles[:, 2]] - a
    twice = 2 * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    bb, cc = (b**2).sum(1), (c**2).sum(1)
    offset = np.stack([c[:, 1] * bb - b[:, 1] * cc, b[:, 0] * cc - c[:, 0] * bb], axis=-1) / twice[:, None]
    return a + offset, np.linalg.norm(offset, axis=1)
