"""Euler transients of whole grids, tile by tile, several steps a pass."""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.euler.grid import Feedback, Schedule, Tiling, steps_of_pass, tile_area, tile_count
from cnnsim.backends.cpu.euler.scratch import tile_cells, tile_layout
from cnnsim.backends.cpu.euler.settled import MOVING, UNSATURATED, largest_rate, start_check, total
from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import twins
from cnnsim.support import Array


@twins
def dense(
    planes: tuple[Array, Array, Array, Array], feedback: Feedback, tiles: Tiling, schedule: Schedule
) -> tuple[int, bool, float, int]:
    """Run the transient of n grids; ``planes`` (n, rows, cols) are x, two between which the steps go by turns, and w.

    The address of ``tiles`` is that of `tile.stream`. Returns the steps taken, whether all grids have settled, the
    largest |dx/dt| (NaN without a check), and where the end is: 0 in x itself (no step was taken), 1 in the first plane
    of the two, 2 in the second.

    The checks stand in this compiled loop and not in `driver.run`: calls from Python would cost 3 us for every check,
    24 us for the eight checks of an 8 x 8 grid that settles after seven time constants, in 23 us as it is.
    """
    x, first, second, w = planes
    address, depth, height, width, threads = tiles
    steps, check_every, rest, freezes = schedule
    count, r = tile_count(x.shape, height, width), feedback[4]
    scratches = np.empty((threads, tile_cells(depth, r)), x.dtype)
    found = np.empty((threads, 7), np.float64)
    source, target = x, first
    done, where = 0, 0
    settled, largest = False, np.nan
    while True:
        checking = check_every > 0 and (done % check_every == 0 or done == steps)
        measure = done == steps
        while checking:
            for thread in prange(threads):
                scratch, at = scratches[thread], tile_layout(scratches[thread], 1, r)
                start_check(found[thread])
                for tile in range(thread * count // threads, (thread + 1) * count // threads):
                    g, area = tile_area(tile, x.shape, height, width)
                    call(address, (source[g], w[g], target[g], feedback, 1, area, scratch, at, True, rest, measure,
                                   found[thread]))  # fmt: skip
            settled = total(found, MOVING) == 0 or (freezes and total(found, UNSATURATED) == 0)
            if measure:
                largest = largest_rate(found)
                return done, settled, largest, where
            checking = measure = settled  # once more, for the rate
        if done == steps:
            return done, settled, largest, where
        now = steps_of_pass(done, depth, schedule)
        for thread in prange(threads):
            scratch, at = scratches[thread], tile_layout(scratches[thread], now, r)
            for tile in range(thread * count // threads, (thread + 1) * count // threads):
                g, area = tile_area(tile, x.shape, height, width)
                call(address, (source[g], w[g], target[g], feedback, now, area, scratch, at, False, rest, False,
                               found[thread]))  # fmt: skip
        done += now
        where = 2 if where == 1 else 1
        source, target = target, (second if where == 1 else first)
