"""Euler transients in which tiles sleep while no output in them can change; bit for bit the dense transient.

A cell is stuck if |x| >= 1 and its drive pulls it outwards (see `cnnsim.backends.cpu.settled`); only the others, the
restless ones, can change an output, and what they change travels r cells a step. So a tile farther than d r cells from
every restless cell keeps all its outputs for d steps and need not be computed: its states run towards constant drives,
x(k) = d + (1 - h)^k (x - d), and when it wakes up it takes those steps at once, each rounded as it would have been.
When no cell is restless, no output will ever change.
"""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.euler.scratch import PERIODIC, move
from cnnsim.backends.cpu.euler.tile import Rule, tile_area
from cnnsim.backends.cpu.euler.window import CATCH_UP, LOOK, shelve, window_cells
from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.backends.cpu.settled import C0, C1, MOVING, R0, R1, RESTLESS, look_at_nothing, steepest, total
from cnnsim.support import Array

HEIGHT, WIDTH = 32, 64
"""Cells of a tile: small enough to lie still as a whole, wide enough for the vectors."""


@helper
def wake(seen: Array, reach: int, shape: tuple[int, int, int], torus: bool, awake: Array) -> None:
    """Mark the tiles that a restless cell's change can come to when it travels ``reach`` cells."""
    n, rows, cols = shape
    down, across = (rows + HEIGHT - 1) // HEIGHT, (cols + WIDTH - 1) // WIDTH
    for tile in range(n * down * across):
        if seen[tile, RESTLESS] == 0:
            continue
        first = tile // (down * across) * down * across
        r0, r1 = int(seen[tile, R0]) - reach, int(seen[tile, R1]) + reach
        c0, c1 = int(seen[tile, C0]) - reach, int(seen[tile, C1]) + reach
        if not torus:
            r0, r1, c0, c1 = max(r0, 0), min(r1, rows), max(c0, 0), min(c1, cols)
        i = r0
        while i < r1:
            p, j = i % rows, c0
            while j < c1:
                q = j % cols
                awake[first + p // HEIGHT * across + q // WIDTH] = True
                j += min(cols - q, WIDTH - q % WIDTH)
            i += min(rows - p, HEIGHT - p % HEIGHT)


# What follows stands outside `sleeping` because numba would start the threads for every array operation in there.


@helper
def choose(chosen: Array, value: bool) -> None:
    """Choose all tiles, or none."""
    for tile in range(chosen.size):
        chosen[tile] = value


@helper
def choose_work(chosen: Array, differs: Array, work: Array) -> int:
    """List the tiles that are to be stepped or copied; return how many they are."""
    count = 0
    for tile in range(chosen.size):
        if chosen[tile] or differs[tile]:
            work[count] = tile
            count += 1
    return count


@helper
def arrived(chosen: Array, step: int, upto: Array, seen: Array) -> float:
    """Put down that the chosen tiles have come to a step; return how many cells in them still move."""
    moving = 0.0
    for tile in range(chosen.size):
        if chosen[tile]:
            upto[tile] = step
            moving += seen[tile, MOVING]
    return moving


@twins
def sleeping(
    x: Array, first: Array, second: Array, w: Array, rule: Rule, depth: int, window: int, threads: int, steps: int,
    check_every: int, rest: float,
) -> tuple[int, bool, float, int]:  # fmt: skip
    """Run the transient of n grids from ``x`` until all have settled, by turns in the planes ``first`` and ``second``.

    ``window`` is the address of `window.step_window`. Returns the steps taken, whether all grids
    have settled, the largest |dx/dt|, and where the end is (1: ``first``, 2: ``second``), all as
    `dense.dense` would.
    """
    n, rows, cols = x.shape
    down, across = (rows + HEIGHT - 1) // HEIGHT, (cols + WIDTH - 1) // WIDTH
    tiles = n * down * across
    rooms = np.empty((threads, window_cells(HEIGHT, depth, rule.r)), x.dtype)
    seen = np.empty((tiles, 7), np.float64)
    upto, work = np.empty(tiles, np.int64), np.empty(tiles, np.int64)  # upto: the step that a tile's states belong to
    chosen, differs = np.empty(tiles, np.bool_), np.empty(tiles, np.bool_)  # differs: not the same in both planes
    choose(chosen, True)
    choose(differs, True)
    source, target, where = first, second, 1
    move(x.reshape(-1), 0, source.reshape(-1), 0, x.size)
    for tile in range(tiles):
        upto[tile] = 0
    done, now, settled, measure = 0, 0, False, False
    while True:
        count = choose_work(chosen, chosen if now == 0 else differs, work)
        for thread in prange(threads):
            room, at = rooms[thread], shelve(rooms[thread], HEIGHT, depth, rule.r)
            for k in range(thread, count, threads):
                tile = work[k]
                g, area = tile // (down * across), tile_area(tile, down, across, HEIGHT, WIDTH, rows, cols)
                if chosen[tile]:
                    # nobody minds that neighbours read this tile now: its outputs stay what they are
                    missed = done - upto[tile]
                    look_at_nothing(seen[tile])
                    for task in range(CATCH_UP if missed > 0 else LOOK, LOOK - 1, -1):
                        to, ahead = (source[g], 0) if task == CATCH_UP else (target[g], now)
                        call(window, (source[g], w[g], to, rule, ahead, area, room, at, task, rest, measure, missed,
                                      seen[tile]))  # fmt: skip
                    differs[tile] = differs[tile] or now > 0 or missed > 0
                else:  # fell asleep: from here on it is the same in both planes
                    for i in range(area.r0, area.r1):
                        move(source[g, i], area.c0, target[g, i], area.c0, area.c1 - area.c0)
                    differs[tile] = False
        done += now
        if now:
            where = 2 if where == 1 else 1
            source, target = (first, second) if where == 1 else (second, first)
        moving = arrived(chosen, done, upto, seen)
        if measure:  # all tiles have been looked at, none has been stepped
            settled = total(seen, RESTLESS) == 0 or total(seen, MOVING) == 0
            if settled or done == steps:
                return done, settled, steepest(seen), where
        frozen, resting = total(seen, RESTLESS) == 0, moving == 0
        if (done % check_every == 0 and (frozen or resting) and not measure) or done == steps:
            measure, now = True, 0
            choose(chosen, True)
        else:
            measure = False
            now = min(depth, steps - done, check_every - done % check_every)
            choose(chosen, False)
            wake(seen, now * rule.r, x.shape, rule.boundary == PERIODIC, chosen)
