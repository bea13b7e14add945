"""Euler transients in which tiles sleep while no output in them can change; bit for bit the dense transient.

Only cells that are not saturated for good (see `cnnsim.backends.cpu.euler.settled`) can change an output, and what they
change travels r cells a step. So a tile farther than d r cells from every such cell keeps all its outputs for d steps
and need not be computed: its states run towards constant drives, x(k) = d + (1 - h)^k (x - d), and when it wakes up it
takes those steps at once, each rounded as it would have been. When all cells are saturated, no output will ever change.
"""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.euler.boundary import is_periodic
from cnnsim.backends.cpu.euler.grid import Feedback, Schedule, Tiling, steps_of_pass, tile_area, tile_count
from cnnsim.backends.cpu.euler.scratch import move
from cnnsim.backends.cpu.euler.settled import C0, C1, MOVING, R0, R1, UNSATURATED, largest_rate, start_check, total
from cnnsim.backends.cpu.euler.window import CATCH_UP, CHECK, window_cells, window_layout
from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.support import Array

HEIGHT, WIDTH = 32, 64
"""Cells of a tile: small enough to lie still as a whole, wide enough for the vectors."""


@helper
def wake(found: Array, reach: int, shape: tuple[int, int, int], periodic: bool, awake: Array) -> None:
    """Mark the tiles that an unsaturated cell's change can come to when it travels ``reach`` cells."""
    n, rows, cols = shape
    down, across = (rows + HEIGHT - 1) // HEIGHT, (cols + WIDTH - 1) // WIDTH
    for tile in range(n * down * across):
        if found[tile, UNSATURATED] == 0:
            continue
        first = tile // (down * across) * down * across
        r0, r1 = int(found[tile, R0]) - reach, int(found[tile, R1]) + reach
        c0, c1 = int(found[tile, C0]) - reach, int(found[tile, C1]) + reach
        if not periodic:
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
def arrived(chosen: Array, step: int, upto: Array, found: Array) -> float:
    """Note that the chosen tiles have come to a step; return how many cells in them still move."""
    moving = 0.0
    for tile in range(chosen.size):
        if chosen[tile]:
            upto[tile] = step
            moving += found[tile, MOVING]
    return moving


@twins
def sleeping(
    planes: tuple[Array, Array, Array, Array], feedback: Feedback, tiles: Tiling, schedule: Schedule
) -> tuple[int, bool, float, int]:
    """Run the transient of n grids until all have settled; everything as in `dense.dense`.

    The address of ``tiles`` is that of `window.step_window`; their size is `HEIGHT` x `WIDTH`.
    """
    x, first, second, w = planes
    address, depth, _, _, threads = tiles
    steps, check_every, rest, _ = schedule
    r, periodic = feedback[4], is_periodic(feedback[4:])
    count = tile_count(x.shape, HEIGHT, WIDTH)
    scratches = np.empty((threads, window_cells(HEIGHT, depth, r)), x.dtype)
    found = np.empty((count, 7), np.float64)
    upto, work = np.empty(count, np.int64), np.empty(count, np.int64)  # upto: the step that a tile's states belong to
    chosen, differs = np.empty(count, np.bool_), np.empty(count, np.bool_)  # differs: not the same in both planes
    choose(chosen, True)
    choose(differs, True)
    source, target, where = first, second, 1
    move(x.reshape(-1), 0, source.reshape(-1), 0, x.size)
    for tile in range(count):
        upto[tile] = 0
    done, now, settled, measure = 0, 0, False, False
    while True:
        to_do = choose_work(chosen, chosen if now == 0 else differs, work)
        for thread in prange(threads):
            scratch, at = scratches[thread], window_layout(scratches[thread], HEIGHT, depth, r)
            for k in range(thread, to_do, threads):
                tile = work[k]
                g, area = tile_area(tile, x.shape, HEIGHT, WIDTH)
                if chosen[tile]:
                    # Neighbours may read this tile while it catches up: a benign data race, its outputs are frozen.
                    missed = done - upto[tile]
                    start_check(found[tile])
                    for task in range(CATCH_UP if missed > 0 else CHECK, CHECK - 1, -1):
                        to, ahead = (source[g], 0) if task == CATCH_UP else (target[g], now)
                        call(address, (source[g], w[g], to, feedback, ahead, area, scratch, at, task, rest, measure,
                                       missed, found[tile]))  # fmt: skip
                    differs[tile] = differs[tile] or now > 0 or missed > 0
                else:  # fell asleep: from here on it is the same in both planes
                    for i in range(area.r0, area.r1):
                        move(source[g, i], area.c0, target[g, i], area.c0, area.c1 - area.c0)
                    differs[tile] = False
        done += now
        if now:
            where = 2 if where == 1 else 1
            source, target = (first, second) if where == 1 else (second, first)
        moving = arrived(chosen, done, upto, found)
        if measure:  # all tiles have been checked, none has been stepped
            settled = total(found, UNSATURATED) == 0 or total(found, MOVING) == 0
            if settled or done == steps:
                return done, settled, largest_rate(found), where
        frozen, resting = total(found, UNSATURATED) == 0, moving == 0
        if (done % check_every == 0 and (frozen or resting) and not measure) or done == steps:
            measure, now = True, 0
            choose(chosen, True)
        else:
            measure = False
            now = steps_of_pass(done, depth, schedule)
            choose(chosen, False)
            wake(found, now * r, x.shape, periodic, chosen)
