"""Answers that need the whole picture: floods, scans, shadows, counts of runs."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy import ndimage

from tests.oracles.pictures import CROSS, SQUARE, Case, Picture, black
from tests.oracles.windows import Window


def fill_holes(picture: Picture) -> Picture:
    """White regions without a 4-connected way out of the picture become black."""
    return np.asarray(ndimage.binary_fill_holes(picture), dtype=bool)


def reconstruct(marker: Picture, within: Picture, neighbours: Picture = SQUARE) -> Picture:
    """The objects of `within` that the marker touches."""
    return np.asarray(ndimage.binary_propagation(marker & within, neighbours, within), dtype=bool)


def drop_damaged(picture: Picture, damaged: Picture) -> Picture:
    """The 4-connected objects of the picture that the damage left whole."""
    labels, _ = ndimage.label(picture, CROSS)
    return picture & ~np.isin(labels, np.unique(labels[picture & ~damaged]))


def shadow(picture: Picture, direction: str) -> Picture:
    """Black from every black cell to the border that the direction names."""
    turns = {"up": 0, "left": 3, "down": 2, "right": 1}[direction]
    turned = np.rot90(picture, turns)
    return np.rot90(np.logical_or.accumulate(turned[::-1], axis=0)[::-1], -turns)


def columns_of(picture: Picture) -> Picture:
    """Every column that holds a black cell, whole."""
    return np.broadcast_to(picture.any(axis=0), picture.shape).copy()


def runs(line: Picture) -> int:
    """Number of separate black runs of a line."""
    return int(np.count_nonzero(np.diff(np.concatenate(([False], line)).astype(int)) == 1))


def _stacked(line: Picture) -> Picture:
    """One black cell for each run, pushed to the end of the line, a white one between each two."""
    out = np.zeros_like(line)
    number = runs(line)
    if number:
        out[::-1][: 2 * number : 2] = True
    return out


def count_right(picture: Picture) -> Picture:
    """The black runs of each row, counted against the right border."""
    return np.array([_stacked(row) for row in picture], dtype=bool).reshape(picture.shape)


def count_down(picture: Picture) -> Picture:
    """The black runs of each column, counted against the lower border."""
    return count_right(picture.T).T


def count_diagonal(picture: Picture) -> Picture:
    """The black runs of each falling diagonal, counted against its lower right end."""
    rows, cols = picture.shape
    out = np.zeros_like(picture)
    for offset in range(1 - rows, cols):
        i = np.arange(max(0, -offset), min(rows, cols - offset))
        out[i, i + offset] = _stacked(picture[i, i + offset])
    return out


def count_right_behind(picture: Picture, walls: Picture) -> Picture:
    """As `count_right`, in each stretch between two walls; picture and walls must not overlap."""
    assert not (picture & walls).any()
    out = np.zeros_like(picture)
    for i in range(picture.shape[0]):
        stops = [-1, *np.flatnonzero(walls[i]).tolist(), picture.shape[1]]
        for left, right in pairwise(stops):
            out[i, left + 1 : right] = _stacked(picture[i, left + 1 : right])
    return out


def erase_from_left(picture: Picture, stops: Picture) -> Picture:
    """Every run loses its cells from the left up to its first stop (all of them, if it has none)."""
    out = np.zeros_like(picture)
    kept = np.zeros(picture.shape[0], dtype=bool)
    for j in range(picture.shape[1]):
        kept = picture[:, j] & (stops[:, j] | kept)
        out[:, j] = kept
    return out


def shadow_left_behind(picture: Picture, walls: Picture) -> Picture:
    """The shadow to the left, ended by walls; picture and walls must not overlap."""
    assert not (picture & walls).any()
    out = np.zeros_like(picture)
    dark = np.zeros(picture.shape[0], dtype=bool)
    for j in reversed(range(picture.shape[1])):
        dark = ~walls[:, j] & (picture[:, j] | dark)
        out[:, j] = dark
    return out


def fill_concavities(picture: Picture) -> Picture:
    """White cells with four or more black neighbours turn black, again and again."""
    while True:
        grown = picture | (Window.of(picture).around8 >= 4)
        if np.array_equal(grown, picture):
            return grown
        picture = grown


def framed_areas(picture: Picture) -> Picture:
    """Start black; drawn cells need two, empty cells four black 4-neighbours to stay; until nothing changes."""
    area = np.ones_like(picture)
    while True:
        left = area & (Window.of(area).around4 >= np.where(picture, 2, 4))
        if np.array_equal(left, area):
            return area
        area = left


def horizontal_runs(picture: Picture) -> Picture:
    """Black cells with a black neighbour in their row; a white gap of one cell is a tie, which is refused."""
    v = Window.of(picture)
    assert not (~v.c & v.w & v.e).any()
    return v.c & (v.w | v.e)


def _free(case: Case) -> Picture:
    start = black(case.start)
    return np.ones_like(start) if case.mask is None else ~case.mask


def flood(case: Case) -> Picture:
    """Black spreads over all free cells that are 8-connected to it; masked cells keep their colour."""
    start = black(case.start)
    return start | reconstruct(start, start | _free(case))
