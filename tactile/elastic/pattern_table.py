"""Tables of what a rigid pattern of loads makes taxels feel, by where they lie from it: made once, read in each frame.

A finger's field under loads that move together is a function of the offset alone. It is kept on nested grids, each
twice as coarse as the one before and reaching twice as far beyond the pattern, and is a cubic B-spline in between.
"""

import math
from functools import lru_cache
from typing import Any

import numpy as np
from scipy import fft

from cnnsim.support import Floats
from tactile.elastic.layer_loads import REACH, layered_load
from tactile.elastic.medium import Felt, Medium

MARGIN = 4.0
"""Depths by which the finest grid reaches beyond the pattern. There a field's fourth
derivative is 1 / (1 + 4^2)^2 as much of the field as in the middle, and the next grid's step to the fourth power is 16
times as large: taxels beside what presses are as accurate as below it. Each grid begins twice as far out as the one
before, and the same holds."""
HELD = MARGIN / 5
"""Depths within which finer grids feel, times their coarseness: well inside what the loads' own spread leaves."""
BEND = 384
"""A cubic spline on even knots is off by at most its step's fourth power times the fourth derivative over this:
(1/4!) of the largest difference of the Bernoulli polynomial, t^2 (1 - t)^2, of all powers above that vanish."""
SHARE = 0.75
"""Of the accuracy that a single load's spline may take along x and y together."""
NEAR, FAR = 12, 8
"""Grid points that a load between them is taken to, so that fields of up to that order stay: on the finest grid, whose
step is at most `COARSEST`, to some 1e-4 of it; on the others, whose loads are far off."""
COARSEST = 0.2
"""Depths, at most, between the points of the finest grid."""
SPREAD = 3.0
"""Depths across from which a pattern is tried with twice the step: it mostly bends less than a single load."""
DEEPEST = 1e8
"""A layer of more depths than this is the half-space to rounding."""
FALL = 0.27
"""By so much a knot what is beyond a grid's end counts less for its spline."""
LARGEST = 1 << 21
"""Numbers of the finest grid, at most: 16 MiB, of which a body may need one for each level of its force."""
WIDTH = 3, 8
"""Columns of a table: readings x, y, z under a normal force; with pulls Q along x and R along y also x of Q, y of Q and
x of R, which are the same, y of R, z of Q, z of R."""


class PatternTable:
    """What taxels feel of a pattern of loads on cells of one pitch, to about an accuracy of its peak.

    Arguments: ``shares`` (rows, cols) of the cells, sum 1; ``middle`` (x, y) of theirs, from where the pattern is said
    to be, and their ``pitch``, both in depths; ``ratio``: depth over the layer's thickness, 0 for the half-space;
    ``nu``; ``quantity``; ``accuracy``; ``columns``: of `WIDTH`.

    ``numbers``: the coefficients of all grids in a row, in units of 1 / depth^2 and for stress or modulus times strain;
    ``grids`` (n, 9): the middle x and y, how far the grid is taken along both, one over its step, its middle's number
    of knot along both, its knots in a row, and where its coefficients begin.
    """

    def __init__(
        self, shares: Floats, middle: tuple[float, float], pitch: float, ratio: float, nu: float, quantity: Felt,
        accuracy: float, columns: int,
    ) -> None:  # fmt: skip
        self.shares, self.middle, self.pitch, self.columns = shares, middle, pitch, columns
        self._cover, self._accuracy = (ratio, nu, quantity), accuracy
        self.step = step_of(ratio, nu, quantity, accuracy)
        self.numbers, self.grids = np.empty(0), np.empty((0, 9))

    def reach(self, offset: float) -> None:
        """Make it reach as far from the pattern's place as this, in depths: beyond, nothing is there on a layer."""
        wanted = min(offset, REACH / self._cover[0] if self._cover[0] else np.inf)
        while not len(self.grids) or self.grids[-1, 2:4].min() < wanted + np.hypot(*self.middle):
            self._add_grid(len(self.grids))

    def _add_grid(self, k: int) -> None:
        step = self.step * 2.0**k
        if k == 0 and (min(self.shares.shape) - 1) * self.pitch > SPREAD and 2 * step < COARSEST:
            found, grid = self._grid(k, 2 * step)
            share = SHARE * self._accuracy / self._off(found, grid)
            if share < 1:
                found, grid = self._grid(k, step * (2**0.5 if share > 1 / 4 else 1))
        else:
            found, grid = self._grid(k, step)
        self.grids = np.concatenate([self.grids, np.array([*grid, self.numbers.size])[None]])
        self.numbers = np.concatenate([self.numbers, found.ravel()])

    def _grid(self, k: int, step: float) -> tuple[Floats, tuple[float, ...]]:
        """Coefficients (rows, cols, columns) of a grid, and how it lies."""
        order = NEAR if k == 0 else FAR
        extent = [(n - 1) * self.pitch for n in self.shares.shape]
        sources = [int(np.ceil(long / step)) + order for long in extent]
        half = [long / 2 + MARGIN * 2**k for long in extent]
        spare = _spare(self._accuracy)
        lead = [max(0, int(np.ceil(h / step + spare - (n - 1) / 2))) for h, n in zip(half, sources, strict=True)]
        knots = [n + 2 * more for n, more in zip(sources, lead, strict=True)]
        size = [fft.next_fast_len(n + m - 1, real=True) for n, m in zip(knots, sources, strict=True)]
        taken = (_taken(n, self.pitch / step, m, order) for n, m in zip(self.shares.shape, sources, strict=True))
        up, across = taken
        waves = fft.rfft2(up @ self.shares @ across.T, s=size)
        felt = _waves(*self._cover, step, k, *sources, *lead, *size, self.columns) * waves
        found = fft.irfft2(felt, s=size, overwrite_x=True)
        cut = [max(0, int((n - 1) / 2 - h / step) - 2) for h, n in zip(half, knots, strict=True)]  # the spare ones
        kept = found[:, cut[0] : knots[0] - cut[0], cut[1] : knots[1] - cut[1]]
        rows, cols = kept.shape[1:]
        middle = (cols - 1) / 2, (rows - 1) / 2
        return np.moveaxis(kept, 0, -1).copy(), (*self.middle, half[1], half[0], 1 / step, *middle, cols)

    def _off(self, found: Floats, grid: tuple[float, ...]) -> float:
        """About how far the spline is off, of the peak below the pattern and of that beside it, whichever is more."""
        _, _, *half, per_depth, x, y, _ = grid
        wide, high = int(half[0] * per_depth), int(half[1] * per_depth)
        read = found[int(y) - high : int(y) + high + 2, int(x) - wide : int(x) + wide + 2]
        bent = np.abs(np.diff(read, 4, axis=0))[:, 2:-2] + np.abs(np.diff(read, 4, axis=1))[2:-2]
        size, worst = np.abs(read[2:-2, 2:-2]), 0.0
        beside = int(MARGIN / 2 * per_depth)
        for aside in (False, True):
            if aside:
                bent[beside:-beside, beside:-beside] = size[beside:-beside, beside:-beside] = 0.0
            for kind in (slice(0, 3), slice(3, self.columns)):
                if kind.start < self.columns:
                    worst = max(worst, float(bent[..., kind].max() / size[..., kind].max()) / BEND)
        return worst


def _taken(cells: int, pitch: float, points: int, order: int) -> Floats:
    """Shares (points, cells) of even points that stand for loads between them, by Lagrange's polynomials."""
    at = (np.arange(cells) - (cells - 1) / 2) * pitch + (points - 1) / 2
    first = np.clip(np.floor(at).astype(int) - order // 2 + 1, 0, points - order)
    numbers, gaps, one = np.arange(order), (at - first)[:, None] - np.arange(order), np.ones((cells, 1))
    before = np.concatenate([one, gaps[:, :-1].cumprod(axis=1)], axis=1)
    after = np.concatenate([gaps[:, :0:-1].cumprod(axis=1)[:, ::-1], one], axis=1)
    whole = [math.factorial(m) * math.factorial(order - 1 - m) * (-1) ** (order - 1 - m) for m in range(order)]
    out = np.zeros((points, cells))
    out[first[:, None] + numbers, np.arange(cells)[:, None]] = before * after / np.array(whole, dtype=np.float64)
    return out


def _point(ratio: float, nu: float, quantity: Felt, x: Floats, y: Floats) -> Floats:
    """Columns (8, ...) of what is felt of unit loads, lengths in depths."""
    medium = Medium(1.0, nu, quantity, 1 / ratio if ratio else np.inf)
    units = np.zeros((3, 1, 5))
    units[:, 0, 2:] = np.eye(3)
    at = np.stack(np.broadcast_arrays(x, y), axis=-1)[..., None, :]
    q, r, f = np.moveaxis(layered_load(at, 1.0, units, medium), (-2, -1), (0, 1))
    return np.stack([*f, q[0], q[1], r[1], q[2], r[2]])


ODD_X, ODD_Y = np.array([1, 0, 0, 0, 1, 0, 1, 0], bool), np.array([0, 1, 0, 0, 1, 0, 0, 1], bool)
"""Which of them change their sign with x, and with y."""


@lru_cache(maxsize=12)
def _waves(
    ratio: float, nu: float, quantity: Felt, step: float, k: int, rows: int, cols: int, lead_y: int, lead_x: int,
    size_y: int, size_x: int, columns: int,
) -> Floats:  # fmt: skip
    """The transform of what is felt of a load on each point of a grid, as coefficients of splines."""
    along = [np.arange(n + lead) * step for n, lead in ((rows, lead_y), (cols, lead_x))]
    x, y = np.meshgrid(along[1], along[0])
    if k:  # what is nearer is felt by finer grids: held so that it is no peak between the points
        x[0, 0] = step
        wide = np.maximum(HELD * 2.0**k / np.maximum(x, y), 1.0)
        x, y = x * wide, y * wide
    quarter = _point(ratio, nu, quantity, x, y)[:columns]
    index, signs, spline = [], [], []
    for n, lead, size in ((rows, lead_y, size_y), (cols, lead_x, size_x)):
        number = np.arange(size)
        number = np.where(number < n + 2 * lead, number, number - size) - lead
        index.append(np.minimum(np.abs(number), n + lead - 1))
        signs.append(np.sign(number))
        spline.append((2 + np.cos(2 * np.pi * np.arange(size) / size)) / 3)
    kernel = quarter[:, index[0][:, None], index[1]]
    kernel[ODD_Y[:columns]] *= signs[0][:, None]
    kernel[ODD_X[:columns]] *= signs[1]
    waves = fft.rfft2(kernel) / (spline[0][:, None] * spline[1][: size_x // 2 + 1])
    return np.asarray(waves)


def depth_ratio(depth: float, medium: Medium) -> float:
    """A depth [m] over the medium's thickness, 0 where that is the half-space to rounding."""
    return round(depth / medium.thickness, 12) if medium.thickness < DEEPEST * depth else 0.0


def table_size(wide: float, high: float, ratio: float, nu: float, quantity: Felt, accuracy: float) -> float:
    """Numbers of the finest grid about a pattern so wide and high in depths, from middle to middle of its cells."""
    step = step_of(ratio, nu, quantity, accuracy)
    return WIDTH[-1] * float(np.prod([(long + 2 * MARGIN) / step + 2 * _spare(accuracy) for long in (wide, high)]))


def _spare(accuracy: float) -> int:
    """Knots beyond what is read of a grid: what wraps around in its transform is not felt through so many."""
    return int(np.ceil(np.log(accuracy / 10) / np.log(FALL)))


@lru_cache(maxsize=64)
def step_of(ratio: float, nu: float, quantity: Felt, accuracy: float) -> float:
    """Depths between the points of the finest grid, with which what is felt of one load is as accurate as is asked."""
    tried, steps = 0.1, np.arange(60)
    x, y = np.meshgrid((steps - 12) * tried, (steps - 12) * tried)
    felt = _point(ratio, nu, quantity, x, y)
    bent: Any = np.abs(np.diff(felt, 4, axis=1)).max(axis=(1, 2)) + np.abs(np.diff(felt, 4, axis=2)).max(axis=(1, 2))
    peak = np.abs(felt).max(axis=(1, 2))
    worst = max(bent[kind].max() / peak[kind].max() for kind in (slice(0, 3), slice(3, 8))) / tried**4
    return float(min((SHARE * accuracy * BEND / worst) ** 0.25, COARSEST))
