"""Expected outputs of the non-linear templates, without a network: ranks, differences, rules, floods."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from itertools import product

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from tests.oracles.pictures import SQUARE, Case, Picture, Plane, black, plane

AROUND = [(k, l) for k, l in product((-1, 0, 1), repeat=2) if (k, l) != (0, 0)]


def neighbours(u: Plane, outside: float | None) -> npt.NDArray[np.float64]:
    """The 8 neighbours of every cell, (8, rows, cols); outside is a constant, or None: the nearest cell."""
    around = np.pad(u, 1, mode="edge") if outside is None else np.pad(u, 1, constant_values=outside)
    rows, cols = u.shape
    return np.stack([around[1 + k : 1 + k + rows, 1 + l : 1 + l + cols] for k, l in AROUND])


def differences(u: Plane, outside: float | None = None) -> npt.NDArray[np.float64]:
    """Neighbour minus centre."""
    return neighbours(u, outside) - u


def everywhere(true: npt.NDArray[np.bool_]) -> Picture:
    """Where all 8 neighbours agree."""
    return np.asarray(true.all(axis=0))


def clip(values: npt.ArrayLike) -> Plane:
    return np.clip(np.asarray(values, dtype=float), -1, 1)


def sum_of_differences(case: Case) -> Plane:
    return np.asarray(np.abs(differences(case.picture)).sum(axis=0))


def contour(case: Case) -> Plane:
    return plane((np.abs(differences(case.picture, 0.0)) > 0.18).sum(axis=0) >= 5)


def flat(case: Case) -> Plane:
    """Each neighbour votes 1 if it is the same, down to -1 at a difference of 0.2, -2 from 0.21 on."""
    d = np.abs(differences(case.picture, 0.0))
    votes = np.where(d <= 0.2, 1 - 10 * d, np.where(d >= 0.21, -2, -1 - 100 * (d - 0.2)))
    return plane(votes.sum(axis=0) > -3.9)


def gray_line(case: Case) -> Plane:
    """Votes: N, NE, E and SW are as dark as the cell, NW, W, S and SE are lighter; a dark cell needs one vote less."""
    lighter = -differences(case.picture)
    votes = (np.abs(lighter[[1, 2, 4, 5]]) <= 0.15).sum(axis=0) + (lighter[[0, 3, 6, 7]] > 0.25).sum(axis=0)
    return plane(votes - 4.5 + 0.5 * case.picture > 0)


def gray_diagonal(sign: int) -> Callable[[Case], Plane]:
    """Votes of +-1/2: cells within one place of the diagonal are as dark as the cell, all others are lighter."""

    def solve(case: Case) -> Plane:
        rows, cols = case.picture.shape
        around, votes = np.pad(case.picture, 2), np.full((rows, cols), -1.8)
        for k, l in np.ndindex(5, 5):
            lighter = case.picture - around[k : k + rows, l : l + cols] > 0.18
            on_band = abs((k - 2) - sign * (l - 2)) <= 1
            votes += 0 if (k, l) == (2, 2) else np.where(lighter == on_band, -0.5, 0.5)
        return plane(votes > 0)

    return solve


def rank(number: int) -> Callable[[Case], Plane]:
    """The neighbour of that rank, 0 the smallest of 8, and the next one's mean."""

    def solve(case: Case) -> Plane:
        ordered = np.sort(neighbours(case.picture, None), axis=0)
        return np.asarray((ordered[number] + ordered[number + 1]) / 2)

    return solve


def life(alive: Picture) -> Picture:
    """One generation; nothing lives outside."""
    count = ndimage.convolve(alive.astype(int), SQUARE.astype(int), mode="constant") - alive
    return np.asarray((count == 3) | (alive & (count == 2)))


def life_layers(case: Case) -> Plane:
    """The three layers after two steps: three alive in the 3x3 window, at most three around, and both: the next one."""
    alive = black(case.picture)
    nine = ndimage.convolve(alive.astype(int), SQUARE.astype(int), mode="constant")
    at_least_three = plane(nine >= 3)
    at_most_three = plane(nine - alive <= 3)
    return np.stack([at_least_three, at_most_three, plane(life(alive))])


def flood_holes(case: Case) -> Plane:
    return plane(ndimage.binary_fill_holes(black(case.picture)))


def rings(case: Case) -> Plane:
    """Depth 1, 3, 5 ... of an object black, 2, 4 ... white; depth counts 4-connected layers from the outside."""
    depth = ndimage.distance_transform_cdt(np.pad(black(case.picture), 1), metric="taxicab")[1:-1, 1:-1]
    return plane(depth % 2 == 1)


def arrival(walls: Picture, start: Picture, steps: int) -> Picture:
    """Cells at most a number of king's moves from the start, around the walls."""
    distance = np.full(walls.shape, -1)
    queue: deque[tuple[int, int]] = deque()
    for i, j in np.argwhere(start & ~walls):
        distance[i, j] = 0
        queue.append((int(i), int(j)))
    while queue:
        i, j = queue.popleft()
        for k, l in AROUND:
            a, b = i + k, j + l
            if 0 <= a < walls.shape[0] and 0 <= b < walls.shape[1] and not walls[a, b] and distance[a, b] < 0:
                distance[a, b] = distance[i, j] + 1
                queue.append((a, b))
    return np.asarray((distance >= 0) & (distance <= steps))


def slid_left(case: Case) -> Plane:
    picture = black(case.start)
    return plane(np.arange(picture.shape[1]) < picture.sum(axis=1, keepdims=True))


def runs_at_right(case: Case) -> Plane:
    """One black cell a run of each row, at the right, every second cell."""
    picture = black(case.start)
    runs = (np.diff(np.pad(picture, ((0, 0), (1, 0))).astype(int), axis=1) > 0).sum(axis=1)
    cols = picture.shape[1]
    from_right = cols - 1 - np.arange(cols)
    return plane((from_right % 2 == 0) & (from_right // 2 < runs[:, None]))


ANSWERS: dict[str, Callable[[Case], Plane]] = {
    "average-gradient": lambda case: clip(sum_of_differences(case) / 8),
    "mean-difference": lambda case: clip(sum_of_differences(case) / 16),
    "gradient-threshold": lambda case: plane(sum_of_differences(case) > 4.8),
    "gradient-threshold-bistable": lambda case: plane(sum_of_differences(case) - 1.8 + case.picture > 0),
    "flat-places": flat,
    "gray-contour": contour,
    "local-maxima": lambda case: plane(everywhere(neighbours(case.picture, -1.0) < case.picture)),
    "local-maxima-matcnn": lambda case: plane(everywhere(differences(case.picture, -1.0) <= 0.01)),
    "local-minima": lambda case: plane(everywhere(differences(case.picture, 1.0) > -0.01)),
    "median": rank(3),
    "gray-dilation": lambda case: np.maximum(neighbours(case.picture, None).max(axis=0), case.picture),
    "gray-erosion": lambda case: np.minimum(neighbours(case.picture, None).min(axis=0), case.picture),
    "global-maximum": lambda case: np.full(case.start.shape, case.start.max()),
    "global-maximum-matcnn": lambda case: np.full(case.start.shape, case.start.max()),
    "global-minimum": lambda case: np.full(case.start.shape, case.start.min()),
    "edge-enhancement": lambda case: np.asarray(
        ((differences(case.picture) <= -0.2).sum(axis=0) - (differences(case.picture) > 0.2).sum(axis=0)) / 8
    ),
    "gray-line-30-60": gray_line,
    "gray-diagonal-nw-se": gray_diagonal(1),
    "gray-diagonal-ne-sw": gray_diagonal(-1),
    "row-histogram": slid_left,
    "life-discrete": life_layers,
    "life-discrete-1-layer": lambda case: plane(life(black(case.start))),
    "discrete-connected-components": runs_at_right,
    "discrete-hole-filler": flood_holes,
    "discrete-edge": lambda case: plane(black(case.picture) & ~ndimage.binary_erosion(black(case.picture))),
    "concentric-contour": rings,
    "discrete-increase": lambda case: plane(ndimage.binary_dilation(black(case.start), SQUARE)),
    "discrete-decrease": lambda case: plane(ndimage.binary_erosion(black(case.start), SQUARE)),
    "pathfinder-wave": lambda case: plane(arrival(black(case.picture), black(case.start), 10**9)),
}
"""The answer of every template beyond the linear kind that has an independent definition."""
