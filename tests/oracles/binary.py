"""What the binary templates have to answer, said without a network: window rules, floods, scans and runs.

A picture is a boolean array here, True where black. The rules of 3x3 windows are written from each template's
task, never from its numbers, so that a wrong number in a template file cannot hide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy import ndimage

Picture = npt.NDArray[np.bool_]
Plane = npt.NDArray[np.float64]

CROSS: Picture = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], dtype=bool)
SQUARE: Picture = np.ones((3, 3), dtype=bool)


@dataclass(frozen=True)
class Case:
    """What a worked example gives: the input, the initial state, the held cells and the bias map."""

    u: Plane | None = None
    x0: Plane | None = None
    held: Picture | None = None
    bias: Plane | None = None

    @property
    def picture(self) -> Plane:
        """The first picture of the example: its input, or its state where it has no input."""
        chosen = self.u if self.u is not None else self.x0
        assert chosen is not None
        return chosen

    @property
    def start(self) -> Plane:
        """The initial state; the input stands in where the template starts from its own input."""
        chosen = self.x0 if self.x0 is not None else self.u
        assert chosen is not None
        return chosen


def black(plane: Plane) -> Picture:
    """Which cells of a plane are black."""
    return np.asarray(plane > 0, dtype=bool)


def plane(picture: Picture) -> Plane:
    """Black to +1, white to -1."""
    return np.where(picture, 1.0, -1.0)


# --- rules of the 3x3 window ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Window:
    """The nine cells around every cell, named by the compass, True where black."""

    nw: Picture
    n: Picture
    ne: Picture
    w: Picture
    c: Picture
    e: Picture
    sw: Picture
    s: Picture
    se: Picture

    @classmethod
    def of(cls, picture: Picture, outside: bool = False) -> Window:
        """The windows of a picture with a one-colour outside."""
        rows, cols = picture.shape
        wide = np.pad(picture, 1, constant_values=outside)
        return cls(*(wide[i : i + rows, j : j + cols] for i in range(3) for j in range(3)))

    @property
    def around4(self) -> npt.NDArray[np.int_]:
        """Number of black cells among N, E, S, W."""
        return _count(self.n, self.e, self.s, self.w)

    @property
    def around8(self) -> npt.NDArray[np.int_]:
        """Number of black cells among the eight neighbours."""
        return self.around4 + _count(self.nw, self.ne, self.sw, self.se)

    @property
    def all9(self) -> npt.NDArray[np.int_]:
        """Number of black cells in the window, the centre included."""
        return self.around8 + _count(self.c)


def _count(*cells: Picture) -> npt.NDArray[np.int_]:
    return np.sum([np.asarray(cell, dtype=int) for cell in cells], axis=0)


def _all(*cells: Picture) -> Picture:
    return np.logical_and.reduce(cells)


def _none(*cells: Picture) -> Picture:
    return ~np.logical_or.reduce(cells)


def _pattern_matches(v: Window) -> npt.NDArray[np.int_]:
    """Agreements with the pattern: the centre and the four diagonals black, north and south white."""
    return _count(v.c, v.nw, v.ne, v.sw, v.se, ~v.n, ~v.s)


Rule = Callable[[Window], Picture]


def _removed(condition: Rule) -> Rule:
    """A peeling step: black stays black except where the condition holds."""
    return lambda v: v.c & ~condition(v)


def _edge(v: Window) -> Picture:
    return v.c & (v.around8 < 8)


def _corner(v: Window) -> Picture:
    return v.c & (8 - v.around8 >= 5)


RULES: dict[str, Rule] = {
    "edge": _edge,
    "edge-no-feedback": _edge,
    "edge-gray": _edge,
    "corner": _corner,
    "corner-chip-1": _corner,
    "corner-chip-2": _corner,
    "corner-bistable": _corner,
    "point-extraction": lambda v: v.c & (v.around8 == 0),
    "point-removal": lambda v: v.c & (v.around8 > 0),
    "junction": lambda v: v.c & (v.around8 >= 3),
    "diagonal-line-remover": lambda v: v.c & _none(v.nw, v.ne, v.sw, v.se),
    "vertical-line-remover": lambda v: v.c & _none(v.n, v.s),
    "horizontal-line-remover": lambda v: v.c & _none(v.w, v.e),
    "diagonal-line-detector": lambda v: _all(v.c, v.ne, v.sw) & _none(v.nw, v.se),
    "local-southern-element": lambda v: v.c & _none(v.sw, v.s, v.se),
    "local-concave-place": lambda v: _all(v.w, v.c, v.e) & ~v.s & (v.sw | v.se),
    "contour-right": lambda v: v.w & v.c & ~v.e,
    "contour-left": lambda v: v.e & v.c & ~v.w,
    "contour-top": lambda v: v.s & v.c & ~v.n,
    "contour-bottom": lambda v: v.n & v.c & ~v.s,
    "contour-south-east": lambda v: v.nw & v.c & ~v.se,
    "peel-left": lambda v: v.w & v.c,
    "erosion-l-shape": lambda v: _all(v.n, v.c, v.e),
    "dilation-l-shape": lambda v: v.w | v.c | v.s,
    "erosion-cross": lambda v: v.c & (v.around4 == 4),
    "dilation-cross": lambda v: v.c | (v.around4 > 0),
    "erosion-cross-bistable": lambda v: v.c & (v.around4 == 4),
    "dilation-cross-bistable": lambda v: v.c | (v.around4 > 0),
    "erosion-square": lambda v: v.all9 == 9,
    "dilation-square": lambda v: v.all9 > 0,
    "erosion-2x2": lambda v: _all(v.n, v.ne, v.c, v.e),
    "dilation-2x2": lambda v: v.w | v.c | v.sw | v.s,
    "erosion-horizontal": lambda v: _all(v.w, v.c, v.e),
    "center-weighted-majority": lambda v: np.where(v.c, v.around8 >= 4, v.around8 >= 6),
    "majority": lambda v: v.all9 >= 5,
    "majority-8-of-9": lambda v: v.all9 >= 8,
    "pattern-match": lambda v: _pattern_matches(v) == 7,
    "pattern-match-tolerant": lambda v: _pattern_matches(v) >= 6,
    # a picture that moves north shows in each cell what was south of it
    "shift-n": lambda v: v.s,
    "shift-ne": lambda v: v.sw,
    "shift-e": lambda v: v.w,
    "shift-se": lambda v: v.nw,
    "shift-s": lambda v: v.n,
    "shift-sw": lambda v: v.ne,
    "shift-w": lambda v: v.e,
    "shift-nw": lambda v: v.se,
    "skeleton-1": _removed(lambda v: _none(v.nw, v.n, v.w) & v.e & v.s),
    "skeleton-2": _removed(lambda v: _none(v.nw, v.n, v.ne) & v.s & (v.sw | v.se)),
    "skeleton-3": _removed(lambda v: _none(v.n, v.ne, v.e) & v.w & v.s),
    "skeleton-4": _removed(lambda v: _none(v.ne, v.e, v.se) & v.w & (v.nw | v.sw)),
    "skeleton-5": _removed(lambda v: _none(v.e, v.se, v.s) & v.n & v.w),
    "skeleton-6": _removed(lambda v: _none(v.sw, v.s, v.se) & v.n & (v.nw | v.ne)),
    "skeleton-7": _removed(lambda v: _none(v.s, v.sw, v.w) & v.n & v.e),
    "skeleton-8": _removed(lambda v: _none(v.nw, v.w, v.sw) & v.e & (v.ne | v.se)),
    "skeleton-4-connected-1": _removed(lambda v: _all(v.nw, v.n, v.w) & _none(v.e, v.se, v.s)),
    "skeleton-4-connected-2": _removed(lambda v: _all(v.nw, v.n, v.ne) & _none(v.sw, v.s, v.se)),
    "skeleton-4-connected-3": _removed(lambda v: _all(v.n, v.ne, v.e) & _none(v.w, v.sw, v.s)),
    "skeleton-4-connected-4": _removed(lambda v: _all(v.ne, v.e, v.se) & _none(v.nw, v.w, v.sw)),
    "skeleton-4-connected-5": _removed(lambda v: _all(v.e, v.se, v.s) & _none(v.nw, v.n, v.w)),
    "skeleton-4-connected-6": _removed(lambda v: _all(v.sw, v.s, v.se) & _none(v.nw, v.n, v.ne)),
    "skeleton-4-connected-7": _removed(lambda v: _all(v.w, v.sw, v.s) & _none(v.n, v.ne, v.e)),
    "skeleton-4-connected-8": _removed(lambda v: _all(v.nw, v.w, v.sw) & _none(v.ne, v.e, v.se)),
    "horizontal-skeleton-left": _removed(lambda v: _none(v.nw, v.w, v.sw) & v.e),
    "horizontal-skeleton-right": _removed(lambda v: _none(v.ne, v.e, v.se) & v.w),
    "vertical-skeleton-top": _removed(lambda v: _none(v.nw, v.n, v.ne) & v.s),
    "vertical-skeleton-bottom": _removed(lambda v: _none(v.sw, v.s, v.se) & v.n),
    "center-point-1": _removed(lambda v: _none(v.nw, v.w, v.sw) & v.e),
    "center-point-2": _removed(lambda v: _none(v.nw, v.n, v.ne, v.w, v.sw) & v.se),
    "center-point-3": _removed(lambda v: _none(v.nw, v.n, v.ne) & v.s),
    "center-point-4": _removed(lambda v: _none(v.nw, v.n, v.ne, v.e, v.se) & v.sw),
    "center-point-5": _removed(lambda v: _none(v.ne, v.e, v.se) & v.w),
    "center-point-6": _removed(lambda v: _none(v.ne, v.e, v.se, v.s, v.sw) & v.nw),
    "center-point-7": _removed(lambda v: _none(v.sw, v.s, v.se) & v.n),
    "center-point-8": _removed(lambda v: _none(v.nw, v.w, v.sw, v.s, v.se) & v.ne),
    "life-layer-1": lambda v: v.around8 <= 3,
    "life-layer-2": lambda v: v.all9 <= 2,
    "dead-end-filler": lambda v: v.c | (v.around4 >= 3),
    "logic-not": lambda v: ~v.c,
}
"""Templates that look at one binary picture through a 3x3 window and do not propagate."""

OUTSIDE_BLACK = frozenset({"erosion-square", "dead-end-filler"})
"""Where the world around the picture counts as black; everywhere else it is white."""

LOGIC: dict[str, Callable[[Picture, Picture], Picture]] = {
    "logic-and": lambda u, x: u & x,
    "logic-or": lambda u, x: u | x,
    "logic-difference": lambda u, x: x & ~u,
    "logic-or-not": lambda u, x: x | ~u,
}
"""Cell by cell, of the input u and the initial state x."""


def window_answer(name: str, picture: Picture) -> Picture:
    """The answer of a window rule to a whole picture."""
    return np.asarray(RULES[name](Window.of(picture, name in OUTSIDE_BLACK)), dtype=bool)


# --- answers that need the whole picture ------------------------------------------------------------------------


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
    """Cells with a black neighbour in their row; a white gap of a single cell is a tie and not allowed."""
    v = Window.of(picture)
    assert not (~v.c & v.w & v.e).any()
    return v.c & (v.w | v.e)


def _free(case: Case) -> Picture:
    start = black(case.start)
    return np.ones_like(start) if case.held is None else ~case.held


def flood(case: Case) -> Picture:
    """Black spreads over all free cells that it can reach, also diagonally; held cells keep their colour."""
    start = black(case.start)
    return start | reconstruct(start, start | _free(case))


def _of_input(answer: Callable[[Picture], Picture]) -> Callable[[Case], Plane]:
    return lambda case: plane(answer(black(case.picture)))


def _of_both(answer: Callable[[Picture, Picture], Picture]) -> Callable[[Case], Plane]:
    """An answer from the initial state and the input, in this order."""

    def solve(case: Case) -> Plane:
        assert case.u is not None and case.x0 is not None
        return plane(answer(black(case.x0), black(case.u)))

    return solve


def _window(name: str) -> Callable[[Case], Plane]:
    return _of_input(lambda picture: window_answer(name, picture))


def _mirrored(
    answer: Callable[[Picture, Picture], Picture],
) -> Callable[[Picture, Picture], Picture]:
    return lambda x, u: answer(x[:, ::-1], u[:, ::-1])[:, ::-1]


ANSWERS: dict[str, Callable[[Case], Plane]] = {
    **{name: _window(name) for name in RULES if name != "edge-gray"},
    **{name: _of_both(lambda x, u, rule=rule: rule(u, x)) for name, rule in LOGIC.items()},  # type: ignore[misc]
    "fill-black": _of_input(np.ones_like),
    "fill-white": _of_input(np.zeros_like),
    "hole-filler": _of_input(fill_holes),
    "shadow-left": _of_input(lambda p: shadow(p, "left")),
    "shadow-right": _of_input(lambda p: shadow(p, "right")),
    "shadow-up": _of_input(lambda p: shadow(p, "up")),
    "shadow-down": _of_input(lambda p: shadow(p, "down")),
    "shadow-vertical": _of_input(columns_of),
    "connected-components-horizontal": _of_input(count_right),
    "connected-components-vertical": _of_input(count_down),
    "connected-components-diagonal": _of_input(count_diagonal),
    "masked-connected-components-right": _of_both(count_right_behind),
    "masked-connected-components-left": _of_both(_mirrored(count_right_behind)),
    "recall": _of_both(reconstruct),
    "figure-reconstructor": _of_both(reconstruct),
    "connectivity": _of_both(lambda x, u: drop_damaged(u, x)),
    "concave-filler": _of_input(fill_concavities),
    "masked-erase": _of_both(erase_from_left),
    "masked-shadow": _of_both(shadow_left_behind),
    "framed-areas": _of_input(framed_areas),
    "horizontal-line-detector": _of_input(horizontal_runs),
}
"""The answer of every binary template that has an independent definition, to a worked example."""
