"""Euler transients in which tiles sleep while no output in them can change; bit for bit the dense transient.

Only cells that are not saturated for good (see `cnnsim.backends.cpu.tiles.settled`) can change an output, and what they
change travels r cells a step. So a tile farther than d r cells from every such cell keeps all its outputs for d steps
and need not be computed: its states run towards constant drives, x(k) = d + (1 - h)^k (x - d), and when it wakes up it
takes those steps at once, each rounded as it would have been. When all cells are saturated, no output will ever change.
"""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.backends.cpu.tiles.boundary import is_periodic
from cnnsim.backends.cpu.tiles.grid import Area, Feedback, Schedule, Tiling, steps_of_pass
from cnnsim.backends.cpu.tiles.position import BEGIN, END, MEASURE, STEP, Fields, Position
from cnnsim.backends.cpu.tiles.scratch import clear, move
from cnnsim.backends.cpu.tiles.settled import C0, C1, MOVING, R0, R1, UNSATURATED, largest_rate, start_check, total
from cnnsim.backends.cpu.tiles.window import CATCH_UP, CHECK, HEIGHT, window_cells, window_layout
from cnnsim.support import Array

WIDTH = 64
"""Columns of a tile: wide enough for the vectors, and small enough, with `HEIGHT` rows, to lie still as a whole."""
MOST = 4
"""Tiles below each other that are stepped as one, so that rows around them are computed again for all at once: of a
picture of 1024 x 1024 with holes the area computed is 18 % then, 25 % one by one, and 23 % by tiles twice as high."""
UPTO, CHOSEN, DIFFERS, WORK, COUNT = range(7, 12)
COLUMNS = 12
"""What is known of each tile from pass to pass: after what a check finds (`settled`) the step that its states belong
to, whether it is to be stepped, and whether it differs between the planes. Columns WORK and COUNT are the list of what
is to be done: a tile, and how many it makes with those below it. Tiles are counted column by column.
"""
E_FOLDS = 40
"""Time constants after which a state that goes to a constant drive changes no bit any more, not even of float64."""


@helper
def wake(found: Array, reach: int, shape: tuple[int, int, int], periodic: bool, by_columns: bool) -> None:
    """Choose the tiles that an unsaturated cell's change can come to when it travels ``reach`` cells.

    They are counted column by column, or row by row.
    """
    n, rows, cols = shape
    down, across = (rows + HEIGHT - 1) // HEIGHT, (cols + WIDTH - 1) // WIDTH
    below, beside = (1, down) if by_columns else (across, 1)
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
                found[first + q // WIDTH * beside + p // HEIGHT * below, CHOSEN] = 1
                j += min(cols - q, WIDTH - q % WIDTH)
            i += min(rows - p, HEIGHT - p % HEIGHT)


# What follows stands outside `sleeping` because numba would start the threads for every array operation in there.


@helper
def begin_tiles(tiles: Array) -> None:
    """Choose all tiles; they are at step 0, in one plane alone."""
    for tile in range(tiles.shape[0]):
        tiles[tile, UPTO] = 0
        tiles[tile, CHOSEN] = tiles[tile, DIFFERS] = 1


@helper
def choose(tiles: Array, value: bool) -> None:
    """Choose all tiles, or none."""
    for tile in range(tiles.shape[0]):
        tiles[tile, CHOSEN] = value


@helper
def area_of(tile: int, tiles: int, shape: tuple[int, int, int]) -> tuple[int, Area]:
    """Return the grid and the cells of a tile with those below it, so many in all."""
    _, rows, cols = shape
    down, across = (rows + HEIGHT - 1) // HEIGHT, (cols + WIDTH - 1) // WIDTH
    r0, c0 = tile % down * HEIGHT, tile // down % across * WIDTH
    return tile // (down * across), Area(r0, min(rows, r0 + tiles * HEIGHT), c0, min(cols, c0 + WIDTH))


@helper
def choose_work(tiles: Array, with_different: bool, rows: int, done: int) -> tuple[int, int]:
    """List the tiles that are to be stepped, or also copied; return where to begin, and how long the list is.

    The list is gone through twice: first all that is chosen is taken to the step ``done``, where any is behind.
    """
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
    return 0 if behind else count, count


@helper
def work_of(tiles: Array, place: int, done: int, now: int, h: float) -> int:
    """Return how many steps of a tile an entry of the list takes at most in a pass, with its check."""
    first, work = int(tiles[place, WORK]), 1
    if tiles[first, CHOSEN]:
        for tile in range(first, first + int(tiles[place, COUNT])):
            work += now + 2 + min(done - int(tiles[tile, UPTO]), int(E_FOLDS / h))
    return work


@helper
def last_of_slice(
    tiles: Array, first: int, to_do: int, threads: int, pass_of: tuple[int, int, float], left: int
) -> tuple[int, int]:
    """Return which place in the list of tiles to do a slice goes up to, and how many steps of a tile are left then.

    ``first`` place of the slice, from ``to_do`` on of the second time through the list; ``pass_of``: the steps done and
    to do now, and their length.
    """
    k, end, (done, now, h) = first, to_do if first < to_do else 2 * to_do, pass_of
    while k < end and (left > 0 or k < first + threads):
        left -= work_of(tiles, k % to_do, done, now, h)
        k += 1
    return k, left


@helper
def arrived(tiles: Array, step: int) -> float:
    """Note that the chosen tiles have come to a step; return how many cells in them still move."""
    moving = 0.0
    for tile in range(tiles.shape[0]):
        if tiles[tile, CHOSEN]:
            tiles[tile, UPTO] = step
            moving += tiles[tile, MOVING]
    return moving


@twins
def sleeping(
    planes: tuple[Array, Array, Array, Array, Array], feedback: Feedback, tiling: Tiling, schedule: Schedule,
    tiles: Array, position: Position, most: int,
) -> tuple[Fields, bool, float]:  # fmt: skip
    """Run a slice of the transient of n grids until all have settled; everything as in `dense.dense`.

    The address of ``tiling`` is that of `window.step_window`; ``tiles`` has `COLUMNS` for each tile of `HEIGHT` x
    `WIDTH` cells.
    """
    x, first, second, w, _ = planes
    address, depth, _, _, threads = tiling
    steps, check_every, rest, _ = schedule
    done, where, phase, k, now, to_do = position
    r, h, periodic = feedback[4], feedback[3], is_periodic(feedback[4:7])
    scratches = np.empty((threads, window_cells(MOST * HEIGHT, depth, r)), x.dtype)
    for thread in range(threads):
        clear(scratches[thread], WIDTH + 2 * (depth + 2) * r)
    looking, whole, largest, settled, left = phase != BEGIN, False, np.nan, False, most
    if phase == BEGIN:
        begin_tiles(tiles)
        phase, where = STEP, 1
        move(x.reshape(-1), 0, first.reshape(-1), 0, x.size)
    while phase != END and left > 0:
        source, target = (first, second) if where == 1 else (second, first)
        if k == 0:
            (k, to_do), whole = choose_work(tiles, now > 0, x.shape[1], done), looking
        measure, begin = phase == MEASURE or whole, k
        k, left = last_of_slice(tiles, begin, to_do, threads, (done, now, h), left)
        for thread in prange(threads):
            scratch, at = scratches[thread], window_layout(scratches[thread], MOST * HEIGHT, depth, r)
            for place in range(begin + thread, k, threads):
                first_tile, count = int(tiles[place % to_do, WORK]), int(tiles[place % to_do, COUNT])
                after = first_tile + count
                g, area = area_of(first_tile, count, x.shape)
                if place < to_do:  # before any is stepped, as its neighbours read states that they take on, too
                    for tile in range(first_tile, after if tiles[first_tile, CHOSEN] else first_tile):
                        missed = done - int(tiles[tile, UPTO])
                        if missed > 0:
                            _, own = area_of(tile, 1, x.shape)
                            call(address, (source[g], w[g], source[g], feedback, 0, own, scratch, at, CATCH_UP, rest,
                                           False, missed, tiles[tile : tile + 1]))  # fmt: skip
                            tiles[tile, UPTO], tiles[tile, DIFFERS] = done, 1
                elif tiles[first_tile, CHOSEN]:
                    for tile in range(first_tile, after):
                        start_check(tiles[tile])
                        if now > 0:
                            tiles[tile, DIFFERS] = 1
                    call(address, (source[g], w[g], target[g], feedback, now, area, scratch, at, CHECK, rest, measure,
                                   0, tiles[first_tile:after]))  # fmt: skip
                else:  # fell asleep: from here on it is the same in both planes
                    for i in range(area.r0, area.r1):
                        move(source[g, i], area.c0, target[g, i], area.c0, area.c1 - area.c0)
                    tiles[first_tile, DIFFERS] = 0
        if k < 2 * to_do:
            continue
        k = 0
        done += now
        if now:
            where = 2 if where == 1 else 1
        moving = arrived(tiles, done)
        if measure:
            largest, looking = largest_rate(tiles), False
        if phase == MEASURE:  # all tiles have been checked, none has been stepped
            settled = total(tiles, UNSATURATED) == 0 or total(tiles, MOVING) == 0
            if settled or done == steps:
                phase = END
                continue
        frozen, resting = total(tiles, UNSATURATED) == 0, moving == 0
        if (done % check_every == 0 and (frozen or resting) and phase != MEASURE) or done == steps:
            phase, now = MEASURE, 0
            choose(tiles, True)
        else:
            phase, now = STEP, steps_of_pass(done, depth, schedule)
            choose(tiles, False)
            wake(tiles, now * r, x.shape, periodic, True)
    return (done, where, phase, k, now, to_do), settled, largest
