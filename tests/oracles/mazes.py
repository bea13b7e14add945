"""Expected outputs of the maze programs, by queues and plain loops."""

from __future__ import annotations

from collections import deque

import numpy as np
import numpy.typing as npt

from tests.oracles.pictures import Picture
from tests.oracles.programs import Answer

Cell = tuple[int, int]


def _beside(cell: Cell, lanes: Picture) -> list[Cell]:
    i, j = cell
    near = [(i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)]
    return [(k, l) for k, l in near if 0 <= k < lanes.shape[0] and 0 <= l < lanes.shape[1] and lanes[k, l]]


def distances(lanes: Picture, start: Picture) -> npt.NDArray[np.int_]:
    """Steps from the nearest start by breadth-first search; -1 where there is no way."""
    steps = np.where(start & lanes, 0, -1)
    queue = deque((int(i), int(j)) for i, j in np.argwhere(start & lanes))
    while queue:
        cell = queue.popleft()
        for other in _beside(cell, lanes):
            if steps[other] < 0:
                steps[other] = steps[cell] + 1
                queue.append(other)
    return steps


def without_dead_ends(walls: Picture, ends: Picture) -> Answer:
    """The lanes that are left when dead ends are taken away one cell at a time, in no particular order."""
    lanes = ~walls | ends
    waiting = [(int(i), int(j)) for i, j in np.argwhere(lanes)]
    while waiting:
        cell = waiting.pop()
        near = _beside(cell, lanes)
        if lanes[cell] and not ends[cell] and len(near) <= 1:
            lanes[cell] = False
            waiting += near
    return {"path": lanes}


def shortest_paths(walls: Picture, start: Picture, goal: Picture) -> Answer:
    there, back = distances(~walls, start), distances(~walls, goal)
    met = (there >= 0) & (back >= 0)
    length = (there + back)[met].min() if met.any() else -1
    return {"path": met & (there + back == length), "length": length}
