"""Rules of the 3x3 window, written from each template's task, never from its numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tests.oracles.pictures import Picture


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
