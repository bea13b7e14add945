"""Expected outputs of the library's programs, by independent methods: labels, floods, ranks and plain loops.

Pictures are boolean arrays, True where black; gray planes are float arrays. Every oracle gives a program's outputs by
name.
"""

from __future__ import annotations

from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage
from skimage.measure import euler_number

from tests.oracles.pictures import CROSS, SQUARE, Picture, Plane

Answer = dict[str, Any]

SKELETONS = {"skeleton": SQUARE, "skeleton-4-connected": CROSS, "thinning": SQUARE}
"""Thinning programs, and the neighbourhood in which their skeletons are connected."""


def count(picture: Picture, neighbours: Picture = SQUARE) -> int:
    """The number of connected objects."""
    return int(ndimage.label(picture, neighbours)[1])


def hole_count(picture: Picture, neighbours: Picture = CROSS) -> int:
    """The number of white regions that do not reach the outside."""
    return count(~np.pad(picture, 1), neighbours) - 1


def touched(picture: Picture, marker: Picture) -> Picture:
    """The 8-connected objects with a cell in the marker, by their labels."""
    labels, _ = ndimage.label(picture, SQUARE)
    return np.asarray(np.isin(labels, np.unique(labels[marker & picture])) & picture)


def eroded(picture: Picture, times: int) -> Picture:
    """Erosion by the 3x3 square with white outside."""
    return np.asarray(ndimage.binary_erosion(picture, SQUARE, iterations=times))


def opening(picture: Picture) -> Answer:
    return {"opened": ndimage.binary_opening(picture, SQUARE)}


def closing(picture: Picture) -> Answer:
    """Closing on a wide white plane, in which cells outside the picture do not prevent filling."""
    wide = ndimage.grey_closing(picture.astype(int), size=3, mode="constant", cval=0) > 0
    dilated = ndimage.binary_dilation(picture, SQUARE)
    closed = np.array([
        [dilated[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2].all() for j in range(picture.shape[1])]
        for i in range(picture.shape[0])
    ])  # fmt: skip
    assert not (wide & ~closed).any()
    return {"closed": closed}


def thinning(picture: Picture) -> Answer:
    """Golay's L by the hit-or-miss transform: rows are black, white, does not matter."""
    hit = np.array([[0, 0, 0], [0, 1, 0], [1, 1, 1]]), np.array([[0, 0, 0], [1, 1, 0], [0, 1, 0]])
    miss = np.array([[1, 1, 1], [0, 0, 0], [0, 0, 0]]), np.array([[0, 1, 1], [0, 0, 1], [0, 0, 0]])
    thin = picture
    while True:
        before = thin
        for turn in range(4):  # clockwise: the side, then the corner to its right
            for black, white in zip(hit, miss, strict=True):
                thin = thin & ~ndimage.binary_hit_or_miss(thin, np.rot90(black, -turn), np.rot90(white, -turn))
        if np.array_equal(thin, before):
            return {"thin": thin}


def areas(picture: Picture) -> Answer:
    filled = ndimage.binary_fill_holes(picture)
    return {
        "holes": filled & ~picture,
        "black": picture.sum(),
        "enclosed": filled.sum(),
        "hole_area": filled.sum() - picture.sum(),
    }


def euler(picture: Picture) -> Answer:
    """Bit quads, by scikit-image."""
    return {"euler": euler_number(picture, connectivity=2)}


def objects(picture: Picture) -> Answer:
    return {"objects": count(picture)}


def holes(picture: Picture) -> Answer:
    return {"objects": count(picture), "holes": hole_count(picture), "euler": count(picture) - hole_count(picture)}


def _runs_at_the_end(line: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """As many single black cells as the line has runs, at its end, one white cell between each two."""
    squeezed = np.zeros_like(line)
    number = sum(black for black, _ in groupby(line.tolist()))
    squeezed[len(line) - 1 - 2 * np.arange(number)] = True
    return squeezed


def runs(picture: Picture) -> Answer:
    rows, columns, diagonals = (np.zeros_like(picture) for _ in range(3))
    for i, row in enumerate(picture):
        rows[i] = _runs_at_the_end(row)
    for j, column in enumerate(picture.T):
        columns[:, j] = _runs_at_the_end(column)
    across, down = np.indices(picture.shape)[::-1]
    for offset in range(1 - picture.shape[0], picture.shape[1]):
        diagonals[across - down == offset] = _runs_at_the_end(picture[across - down == offset])
    planes = {"rows": rows, "columns": columns, "diagonals": diagonals}
    return {
        **planes,
        "row_runs": rows.sum(),
        "column_runs": columns.sum(),
        "diagonal_runs": diagonals.sum(),
    }


def sizes(picture: Picture, medium: int = 1, large: int = 2) -> Answer:
    thicker, thick = (touched(picture, eroded(picture, n)) for n in (medium, large))
    return {"small": picture & ~thicker, "medium": thicker & ~thick, "large": thick}


def band(picture: Picture, at_least: int = 1, too_large: int = 2) -> Answer:
    chosen = sizes(picture, at_least, too_large)["medium"]
    return {"chosen": chosen, "contour": chosen & ~eroded(chosen, 1)}


def isolated(picture: Picture, marker: Picture) -> Answer:
    chosen = touched(picture, marker)
    return {"chosen": chosen, "rest": picture & ~chosen}


def life(picture: Picture, generations: int = 1) -> Answer:
    """Conway's rule, cell by cell."""
    alive = picture
    for _ in range(generations):
        around = ndimage.convolve(alive.astype(int), [[1, 1, 1], [1, 0, 1], [1, 1, 1]], mode="constant")
        alive = (around == 3) | (alive & (around == 2))
    return {"alive": alive}


def gray_opening(picture: Plane, radius: int = 1) -> Answer:
    size = 2 * radius + 1
    darkest = ndimage.grey_erosion(picture, size=(size, size), mode="nearest")
    return {"eroded": darkest, "opened": ndimage.grey_dilation(darkest, size=(size, size), mode="nearest")}


def gray_closing(picture: Plane, radius: int = 1) -> Answer:
    size = 2 * radius + 1
    lightest = ndimage.grey_dilation(picture, size=(size, size), mode="nearest")
    return {"dilated": lightest, "closed": ndimage.grey_erosion(lightest, size=(size, size), mode="nearest")}


def gray_gradient(picture: Plane) -> Answer:
    return {"gradient": ndimage.morphological_gradient(picture, size=(3, 3), mode="nearest") / 2}


def median(picture: Plane) -> Answer:
    return {"median": ndimage.median_filter(picture, size=3, mode="nearest")}


def ranked(picture: Plane, rank: int = 5) -> Answer:
    return {"ranked": ndimage.rank_filter(picture, rank=9 - rank, size=3, mode="nearest")}


def edge_density(picture: Plane, averages: int = 3) -> Plane:
    """Mean size of the differences to the eastern and southern neighbours, scaled to 0..1 and averaged in boxes."""
    wide = np.pad(picture, ((0, 1), (0, 1)), mode="edge")
    density = (np.abs(np.diff(wide, axis=1))[:-1] + np.abs(np.diff(wide, axis=0))[:, :-1]) / 4
    for _ in range(averages):
        density = ndimage.uniform_filter(density, size=3, mode="nearest")
    return density
