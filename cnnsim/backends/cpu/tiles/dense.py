"""Transients of whole grids, tile by tile, several steps a pass."""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import twins
from cnnsim.backends.cpu.tiles.grid import Feedback, Schedule, Tiling, levels_of, steps_of_pass, tile_area, tile_count
from cnnsim.backends.cpu.tiles.position import BEGIN, END, MEASURE, STEP, Fields, Position, phase_at
from cnnsim.backends.cpu.tiles.scratch import clear, tile_cells, tile_layout
from cnnsim.backends.cpu.tiles.settled import MOVING, UNSATURATED, largest_rate, start_check, total
from cnnsim.support import Array


@twins
def dense(
    planes: tuple[Array, Array, Array, Array, Array], feedback: Feedback, tiles: Tiling, schedule: Schedule,
    found: Array, position: Position, most: int,
) -> tuple[Fields, bool, float]:  # fmt: skip
    """Run a slice of the transient of n grids, at least ``most`` steps of a tile, from ``position`` on.

    ``planes`` (n, rows, cols) are x, two between which the steps go by turns, w, and the words of the mask (without
    cells: none). The address of ``tiles`` is that
    of `tile.stream`. ``found`` has a row for each thread. Returns the new position (END: the transient has ended),
    whether all grids have settled, and the largest |dx/dt|: at the end and once a slice, NaN without a check.

    The checks stand in this compiled loop and not in `driver.run`: calls from Python would cost 3 us for every check,
    24 us for the eight checks of an 8 x 8 grid that settles after seven time constants, in 23 us as it is.
    """
    x, first, second, w, mask = planes
    address, depth, height, width, threads = tiles
    _, _, rest, freezes = schedule
    done, where, phase, next_tile, _, _ = position
    count, r, lives = tile_count(x.shape, height, width), feedback[4], feedback[8]
    scratches = np.empty((threads, tile_cells(levels_of(depth, feedback), r, lives)), x.dtype)
    for thread in range(threads):
        clear(scratches[thread], min(width, x.shape[2]) + 2 * levels_of(depth, feedback) * r)
    looking, largest, settled, left = phase != BEGIN, np.nan, False, most
    if phase == BEGIN:
        phase = phase_at(done, schedule)
    while phase != END and left > 0:
        checks = phase != STEP
        now = 1 if checks else steps_of_pass(done, depth, schedule)
        measure = phase == MEASURE or (looking and next_tile == 0)
        source = x if where == 0 else first if where == 1 else second
        target = second if where == 1 else first
        stop = min(count, next_tile + max(threads, left // now))
        for thread in prange(threads):
            scratch, at = scratches[thread], tile_layout(scratches[thread], levels_of(now, feedback), r, lives)
            if next_tile == 0:
                start_check(found[thread])
            for tile in range(next_tile + thread * (stop - next_tile) // threads,
                              next_tile + (thread + 1) * (stop - next_tile) // threads):  # fmt: skip
                g, area = tile_area(tile, x.shape, height, width)
                call(address, (source[g], w[g], mask[g], target[g], feedback, now, area, scratch, at, checks, rest,
                               measure, found[thread]))  # fmt: skip
        left -= now * (stop - next_tile)
        next_tile = stop
        if stop < count:
            continue
        next_tile = 0
        if checks:
            settled = total(found, MOVING) == 0 or (freezes and total(found, UNSATURATED) == 0)
            if measure:
                largest, looking = largest_rate(found), False
            phase = END if phase == MEASURE else MEASURE if settled else STEP
        else:
            done += now
            where = 2 if where == 1 else 1
            phase = phase_at(done, schedule)
    return (done, where, phase, next_tile, 0, 0), settled, largest
