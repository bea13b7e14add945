"""Euler transients of whole grids, tile by tile, several steps a pass."""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.compiled import call, twins
from cnnsim.backends.cpu.tiles.check import FIGURES, all_saturated, largest_of, start_check
from cnnsim.backends.cpu.tiles.grid import Feedback, Schedule, Tiling, steps_of_pass, tile_area, tile_count
from cnnsim.backends.cpu.tiles.scratch import clear
from cnnsim.backends.cpu.tiles.stream import CHECK, stream_cells
from cnnsim.support import Array

Position = tuple[int, int, int, bool, bool]
"""State of a transient between two slices: the steps done; where the state is (0: in the given plane, 1 or 2: in the
planes between which the steps alternate); the next tile of the pass; whether the state has been checked; whether the
transient has ended."""
START: Position = 0, 0, 0, False, False


@twins
def dense(
    planes: tuple[Array, Array, Array, Array], feedback: Feedback, tiling: Tiling, schedule: Schedule,
    position: Position, most: int,
) -> tuple[Position, bool, float, bool]:  # fmt: skip
    """Run a slice of the transient of n grids, at least ``most`` steps of a tile, from a position.

    ``planes`` (n, rows, cols) are x, two between which the steps alternate, and w. The address of ``tiling`` is that of
    `stream`. Return the new position, whether all grids have settled, the largest |dx/dt| of the last check, and
    whether it found only saturated cells.

    The checks are in this compiled loop and not in `driver.run`: eight checks of an 8 x 8 grid that settles after seven
    time constants would take as long as the rest of the transient.
    """
    x, first, second, w = planes
    address, depth, height, width, threads = tiling
    steps, check_every, rest, freezes = schedule
    done, where, tile, checked, ended = position
    count, r, settled, rate, left = tile_count(x.shape, height, width), feedback[4], False, np.nan, most
    frozen = False
    found, scratches = np.empty((threads, FIGURES)), np.empty((threads, stream_cells(depth, r)), x.dtype)
    for thread in range(threads):
        start_check(found[thread])
        clear(scratches[thread], min(width, x.shape[2]) + 2 * depth * r)
    while not ended and left > 0:
        check = check_every > 0 and not checked and (done % check_every == 0 or done == steps)
        if done == steps and not check:
            ended = True
            continue
        now = CHECK if check else steps_of_pass(done, depth, schedule)
        source = x if where == 0 else first if where == 1 else second
        target = second if where == 1 else first
        stop = count if check else min(count, tile + max(threads, left // now))
        for thread in prange(threads):
            for each in range(tile + thread * (stop - tile) // threads, tile + (thread + 1) * (stop - tile) // threads):
                g, area = tile_area(each, x.shape, height, width)
                call(address, ((source[g], w[g], target[g]), feedback, now, area, scratches[thread], found[thread]))
        left -= max(1, now) * (stop - tile)
        tile = stop
        if tile < count:
            continue
        tile = 0
        if check:
            rate, checked = largest_of(found), True
            frozen = freezes and all_saturated(found)
            settled = x.dtype.type(rate) <= rest or frozen
            ended = settled or done == steps
            for thread in range(threads):
                start_check(found[thread])
        else:
            done, where, checked = done + now, 2 if where == 1 else 1, False
    return (done, where, tile, checked, ended), settled, rate, frozen
