"""Steps of a block with what lies around it: pass by pass fewer cells, those that the block still depends on."""

import numba
import numpy as np

from cnnsim.backends.base import Area, check_finite
from cnnsim.backends.cpu.planes import grids
from cnnsim.backends.cpu.pool import Pool
from cnnsim.backends.cpu.prepared import Prepared
from cnnsim.backends.cpu.tiles.narrowing import pass_over
from cnnsim.backends.cpu.tiles.part_sleep import all_caught_up, look, step_awake
from cnnsim.backends.cpu.tiles.sleep import COLUMNS, WIDTH
from cnnsim.backends.cpu.tiles.tile import streaming
from cnnsim.backends.cpu.tiles.tiled import TILE_COLS, TILE_ROWS
from cnnsim.backends.cpu.tiles.window import HEIGHT, window
from cnnsim.planning.plan import Plan
from cnnsim.planning.savings import steps_a_pass
from cnnsim.support import Array

STRIP = 64
"""Rows that are looked at for what is not finite at a time: they stay in the cache."""
EVERY, FEW = 13, 0.15
"""One tile of so many is looked at (a prime: not always the same columns), and up to this share of them may have cells
that are not saturated where tiles sleep: one that is awake takes several times as long as without."""
AHEAD = 16
"""Steps of a pass where tiles sleep: more of them step too much around a tile, and keep tiles awake for longer."""
WORTH = 16
"""Steps from which tiles may sleep: to look at all, and to catch up, takes as long as a handful of steps."""


def advanced(plan: Plan, ready: Prepared, x: Array, w: Array, area: Area, steps: int, pool: Pool) -> Array:
    """Return a plane with the cells of an area after some steps; the others have anything."""
    end = slept(plan, ready, x, w, area, steps, pool) if "sleep" in plan.savings and steps >= WORTH else None
    if end is None:
        end = narrowed(plan, ready, x, w, area, steps, pool)
    (r0, r1), (c0, c1) = area
    for first in range(r0, r1, STRIP):
        strip = end[..., first : min(first + STRIP, r1), c0:c1]
        if not np.isfinite(strip).all():
            check_finite(strip, steps * plan.step)
    return end


def slept(plan: Plan, ready: Prepared, x: Array, w: Array, area: Area, steps: int, pool: Pool) -> Array | None:
    """Return that plane by tiles that sleep; None if too few of them would."""
    feedback, (rows, cols) = ready.tiled.feedback, plan.shape
    addresses = tuple(int(kind(numba.typeof(feedback)).address) for kind in (window, streaming))
    address, r = addresses[0], feedback[4]
    tiles = np.zeros((grids(x).shape[0] * -(-rows // HEIGHT) * -(-cols // WIDTH), COLUMNS))
    if look((grids(x), grids(x), grids(w)), feedback, address, tiles, 0, EVERY) > FEW:
        return None
    end, spare, done = pool.plane(x), pool.plane(x), 0
    end[...] = x
    planes = grids(end), grids(spare), grids(w)
    look(planes, feedback, address, tiles, 0, 1)
    while done < steps:  # a call for each pass, so that Python can hear a signal between them
        now, counts = min(AHEAD, steps - done), _needed_of(plan, area, (steps - done - 1) * r)
        step_awake(planes, feedback, addresses, tiles, done, now, counts)
        done += now
    all_caught_up(planes, feedback, address, tiles, done, (*area[0], *area[1]))
    pool.keep(spare)
    return end


def narrowed(plan: Plan, ready: Prepared, x: Array, w: Array, area: Area, steps: int, pool: Pool) -> Array:
    """Return that plane by passes over what is still needed of it."""
    feedback = ready.tiled.feedback
    address, r = int(streaming(numba.typeof(feedback)).address), feedback[4]
    depth = steps_a_pass(steps, r) if "blocking" in plan.savings else 1
    source, target, spare = x, pool.plane(x), pool.plane(x)
    left = steps
    while left:  # a call for each pass, so that Python can hear a signal between them
        now = min(depth, left)
        left -= now
        top, bottom, start, stop = part = _needed_of(plan, area, left * r)
        tile = _even(bottom - top, TILE_ROWS), _even(stop - start, TILE_COLS)
        pass_over((grids(source), grids(target), grids(w)), feedback, address, tile, now, part)
        source, target = target, spare if source is x else source
    pool.keep(target)
    return source


def _needed_of(plan: Plan, area: Area, margin: int) -> tuple[int, int, int, int]:
    """Return the rows and columns on which an area depends; all of them where that goes around the grid's edge."""
    around, spans = plan.boundary.kind == "periodic", list[int]()
    for (first, after), cells in zip(area, plan.shape, strict=True):
        low, high = first - margin, after + margin
        spans += (0, cells) if around and (low < 0 or high > cells) else (max(low, 0), min(high, cells))
    top, bottom, start, stop = spans
    return top, bottom, start, stop


def _even(cells: int, most: int) -> int:
    """Return the size of even parts of at most so many cells."""
    return -(-cells // -(-cells // most))
