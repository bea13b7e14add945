"""Steps of a block with what lies around it: pass by pass fewer cells, those that the block still depends on."""

import numba
import numpy as np

from cnnsim.backends.base import check_finite
from cnnsim.backends.cpu.planes import grids
from cnnsim.backends.cpu.pool import Pool
from cnnsim.backends.cpu.prepared import Prepared
from cnnsim.backends.cpu.tiles.narrowing import pass_over
from cnnsim.backends.cpu.tiles.tile import streaming
from cnnsim.backends.cpu.tiles.tiled import TILE_COLS, TILE_ROWS
from cnnsim.planning.plan import Plan
from cnnsim.planning.savings import steps_a_pass
from cnnsim.support import Array

STRIP = 64
"""Rows that are looked at for what is not finite at a time: they stay in the cache."""


def narrowed(
    plan: Plan, ready: Prepared, x: Array, w: Array, area: tuple[tuple[int, int], tuple[int, int]], steps: int,
    pool: Pool,
) -> Array:  # fmt: skip
    """Return a plane with the cells of an area after some steps; the others have anything."""
    feedback = ready.tiled.feedback
    address, r = int(streaming(numba.typeof(feedback)).address), feedback[4]
    depth = steps_a_pass(steps, r) if "blocking" in plan.savings else 1
    source, target, spare = x, pool.plane(x), pool.plane(x)
    left = steps
    while left:  # a call for each pass, so that Python can hear a signal between them
        now = min(depth, left)
        left -= now
        part = [
            _needed(first - left * r, after + left * r, cells, around=plan.boundary.kind == "periodic")
            for (first, after), cells in zip(area, plan.shape, strict=True)
        ]
        tile = tuple(
            _even(after - first, most) for (first, after), most in zip(part, (TILE_ROWS, TILE_COLS), strict=True)
        )
        pass_over((grids(source), grids(target), grids(w)), feedback, address, tile, now, (*part[0], *part[1]))
        source, target = target, spare if source is x else source
    pool.keep(target)
    (r0, r1), (c0, c1) = area
    for first in range(r0, r1, STRIP):
        strip = source[..., first : min(first + STRIP, r1), c0:c1]
        if not np.isfinite(strip).all():
            check_finite(strip, steps * plan.step)
    return source


def _needed(first: int, after: int, cells: int, *, around: bool) -> tuple[int, int]:
    """Return the span of cells that are still needed: all of them where it goes ``around`` the grid's edge."""
    if around and (first < 0 or after > cells):
        return 0, cells
    return max(first, 0), min(after, cells)


def _even(cells: int, most: int) -> int:
    """Return the size of even parts of at most so many cells."""
    return -(-cells // -(-cells // most))
