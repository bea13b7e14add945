"""Euler transients in which tiles sleep while no output in them can change; bit for bit the dense transient.

Only cells that are not saturated for good (see `check`) can change an output, and a change travels r cells a step. So a
tile farther than d r cells from every such cell keeps all its outputs for d steps and need not be computed: its states
approach constant drives, x(k) = d + (1 - h)^k (x - d), and when it wakes up it takes those steps at once, each rounded
as it would have been. When all cells are saturated, no output will ever change.
"""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.compiled import call, helper, twins
from cnnsim.backends.cpu.tiles.check import C0, C1, FIGURES, R0, R1, RATE, all_saturated, largest_of, start_check
from cnnsim.backends.cpu.tiles.dense import Position
from cnnsim.backends.cpu.tiles.functions import copy_row
from cnnsim.backends.cpu.tiles.grid import Area, Feedback, Schedule, Tiling, steps_of_pass
from cnnsim.backends.cpu.tiles.scratch import PERIODIC, clear
from cnnsim.backends.cpu.tiles.window import HEIGHT, MOST, WIDTH, window_cells
from cnnsim.support import Array

UPTO, CHOSEN, DIFFERS, WORK, COUNT = range(FIGURES, FIGURES + 5)
COLUMNS = FIGURES + 5
"""Columns of the table of tiles: after the results of the last check, the step of its states, whether it is to be
stepped, and whether it differs between the two planes. WORK and COUNT are a list of what is to be done in a pass: a
tile, and the number of tiles from it downwards. Tiles are counted column by column."""

# The helpers are not part of `sleeping`, because numba would start the threads for every loop over tiles there.


@helper
def _wake(tiles: Array, reach: int, shape: tuple[int, int, int], periodic: bool) -> None:
    """Choose the tiles within ``reach`` of an unsaturated cell."""
    n, rows, cols = shape
    down, across = (rows + HEIGHT - 1) // HEIGHT, (cols + WIDTH - 1) // WIDTH
    for tile in range(n * down * across):
        tiles[tile, CHOSEN] = 0
    for tile in range(n * down * across):
        if tiles[tile, R0] == np.inf:
            continue
        first = tile // (down * across) * down * across
        r0, r1 = int(tiles[tile, R0]) - reach, int(tiles[tile, R1]) + reach
        c0, c1 = int(tiles[tile, C0]) - reach, int(tiles[tile, C1]) + reach
        if not periodic:
            r0, r1, c0, c1 = max(r0, 0), min(r1, rows), max(c0, 0), min(c1, cols)
        i = r0
        while i < r1:
            p, j = i % rows, c0
            while j < c1:
                q = j % cols
                tiles[first + q // WIDTH * down + p // HEIGHT, CHOSEN] = 1
                j += min(cols - q, WIDTH - q % WIDTH)
            i += min(rows - p, HEIGHT - p % HEIGHT)


@helper
def _choose_all(tiles: Array) -> None:
    for tile in range(tiles.shape[0]):
        tiles[tile, CHOSEN] = 1


@helper
def _start(tiles: Array, x: Array, first: Array) -> None:
    """Copy the first state; all tiles are at step 0 and differ between the planes."""
    copy_row(first.reshape(-1), x.reshape(-1))
    for tile in range(tiles.shape[0]):
        tiles[tile, UPTO] = 0
        tiles[tile, CHOSEN] = tiles[tile, DIFFERS] = 1


@helper
def _area_of(tile: int, count: int, shape: tuple[int, int, int]) -> tuple[int, Area]:
    """Return the grid and the cells of ``count`` tiles from one downwards."""
    _, rows, cols = shape
    down, across = (rows + HEIGHT - 1) // HEIGHT, (cols + WIDTH - 1) // WIDTH
    r0, c0 = tile % down * HEIGHT, tile // down % across * WIDTH
    return tile // (down * across), Area(r0, min(rows, r0 + count * HEIGHT), c0, min(cols, c0 + WIDTH))


@helper
def _list_work(tiles: Array, with_different: bool, rows: int, done: int) -> tuple[int, bool]:
    """List the tiles that are to be stepped, or also copied; return the length, and whether a tile missed steps."""
    down, count, tile, behind = (rows + HEIGHT - 1) // HEIGHT, 0, 0, False
    while tile < tiles.shape[0]:
        after = tile + 1
        if tiles[tile, CHOSEN]:
            while after % down > 0 and after < tile + MOST and tiles[after, CHOSEN]:
                after += 1
            for one in range(tile, after):
                behind = behind or tiles[one, UPTO] < done
        if tiles[tile, CHOSEN] or (with_different and tiles[tile, DIFFERS]):
            tiles[count, WORK], tiles[count, COUNT] = tile, after - tile
            count += 1
        tile = after
    return count, behind


@helper
def _arrive(tiles: Array, step: int) -> float:
    """Record that the chosen tiles have reached ``step``; return the largest |dx/dt| in them."""
    rate = 0.0
    for tile in range(tiles.shape[0]):
        if tiles[tile, CHOSEN]:
            tiles[tile, UPTO] = step
            rate = max(rate, tiles[tile, RATE])
    return rate


@twins
def sleeping(
    planes: tuple[Array, Array, Array, Array], feedback: Feedback, tiling: Tiling, schedule: Schedule,
    tiles: Array, position: Position, most: int,
) -> tuple[Position, bool, float, bool]:  # fmt: skip
    """Run a slice of the transient of n grids until all have settled; everything as in `dense.dense`.

    The address of ``tiling`` is that of `step_window`; ``tiles`` has `COLUMNS` for each tile. A slice ends after a
    pass; the third number of a ``position`` is the steps of the next pass (0: a check of all tiles).
    """
    x, first, second, w = planes
    address, depth, _, _, threads = tiling
    steps, check_every, rest, _ = schedule
    done, where, now, _, ended = position
    r, periodic, settled, rate, left = feedback[4], feedback[5] == PERIODIC, False, np.nan, most
    frozen = False
    scratches = np.empty((threads, window_cells(depth, r)), x.dtype)
    for thread in range(threads):
        clear(scratches[thread], WIDTH + 2 * (depth + 2) * r)
    if where == 0:
        _start(tiles, x, first)
        where = 1
    while not ended and left > 0:
        source, target = (first, second) if where == 1 else (second, first)
        count, behind = _list_work(tiles, now > 0, x.shape[1], done)
        if behind:  # before any is stepped, because tiles read the states of their neighbours
            for thread in prange(threads):
                for place in range(thread, count, threads):
                    tile = int(tiles[place, WORK])
                    for each in range(tile, tile + int(tiles[place, COUNT]) if tiles[tile, CHOSEN] else tile):
                        missed = done - int(tiles[each, UPTO])
                        if missed > 0:
                            g, area = _area_of(each, 1, x.shape)
                            call(address, ((source[g], w[g], source[g]), feedback, 0, area, scratches[thread], missed,
                                           tiles[each : each + 1]))  # fmt: skip
                            tiles[each, UPTO], tiles[each, DIFFERS] = done, 1
        for thread in prange(threads):
            for place in range(thread, count, threads):
                tile, after = int(tiles[place, WORK]), int(tiles[place, WORK]) + int(tiles[place, COUNT])
                g, area = _area_of(tile, after - tile, x.shape)
                if tiles[tile, CHOSEN]:
                    for each in range(tile, after):
                        start_check(tiles[each])
                        if now > 0:
                            tiles[each, DIFFERS] = 1
                    call(address, ((source[g], w[g], target[g]), feedback, now, area, scratches[thread], 0,
                                   tiles[tile:after]))  # fmt: skip
                else:  # fell asleep: from now on it is the same in both planes
                    for i in range(area.r0, area.r1):
                        copy_row(target[g, i][area.c0 : area.c1], source[g, i][area.c0 : area.c1])
                    tiles[tile, DIFFERS] = 0
        left -= count * MOST * (now + 2)
        done += now
        if now:
            where = 2 if where == 1 else 1
        rate, frozen = _arrive(tiles, done), all_saturated(tiles)
        over = frozen or x.dtype.type(rate) <= rest
        if now == 0:  # all tiles have been checked
            rate = largest_of(tiles)
            settled = over
            ended = settled or done == steps
        if (now > 0 and done % check_every == 0 and over) or done == steps:
            now = 0
            _choose_all(tiles)
        else:
            now = steps_of_pass(done, depth, schedule)
            _wake(tiles, now * r, x.shape, periodic)
    return (done, where, now, False, ended), settled, rate, frozen
