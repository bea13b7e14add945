"""Euler transients of whole grids, tile by tile, several steps a pass."""

import numpy as np
from numba import prange

from cnnsim.backends.cpu.euler.scratch import divide, room_cells
from cnnsim.backends.cpu.euler.tile import Rule, tile_area
from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import twins
from cnnsim.backends.cpu.settled import MOVING, RESTLESS, look_at_nothing, steepest, total
from cnnsim.support import Array


@twins
def dense(
    x: Array, first: Array, second: Array, w: Array, rule: Rule, depth: int, stream: int, height: int, width: int,
    threads: int, steps: int, check_every: int, rest: float, freezes: bool,
) -> tuple[int, bool, float, int]:  # fmt: skip
    """Run the transient of n grids (n, rows, cols) from ``x``, by turns into the planes ``first`` and ``second``.

    ``stream`` is the address of `tile.stream`. Tiles are ``height`` x ``width`` cells, ``depth``
    steps a pass. Every ``check_every`` steps (0: never) is a look. Returns the steps taken, whether all grids have
    settled, the largest |dx/dt| (NaN if nobody looked), and where the end is: 0 in x itself (no step was taken), 1 in
    ``first``, 2 in ``second``.
    """
    n, rows, cols = x.shape
    down, across = (rows + height - 1) // height, (cols + width - 1) // width
    tiles = n * down * across
    rooms = np.empty((threads, room_cells(depth, rule.r)), x.dtype)
    seen = np.empty((threads, 7), np.float64)
    source, target = x, first
    done, where = 0, 0
    settled, largest = False, np.nan
    while True:
        looking = check_every > 0 and (done % check_every == 0 or done == steps)
        measure = done == steps
        while looking:
            for thread in prange(threads):
                room, at = rooms[thread], divide(rooms[thread], 1, rule.r)
                look_at_nothing(seen[thread])
                for tile in range(thread * tiles // threads, (thread + 1) * tiles // threads):
                    g, area = tile // (down * across), tile_area(tile, down, across, height, width, rows, cols)
                    call(
                        stream, (source[g], w[g], target[g], rule, 1, area, room, at, True, rest, measure, seen[thread])
                    )
            settled = total(seen, MOVING) == 0 or (freezes and total(seen, RESTLESS) == 0)
            if measure:
                largest = steepest(seen)
                return done, settled, largest, where
            looking = measure = settled  # once more, for the slope
        if done == steps:
            return done, settled, largest, where
        now = min(depth, steps - done)
        if check_every > 0:
            now = min(now, check_every - done % check_every)
        for thread in prange(threads):
            room, at = rooms[thread], divide(rooms[thread], now, rule.r)
            for tile in range(thread * tiles // threads, (thread + 1) * tiles // threads):
                g, area = tile // (down * across), tile_area(tile, down, across, height, width, rows, cols)
                call(stream, (source[g], w[g], target[g], rule, now, area, room, at, False, rest, False, seen[thread]))
        done += now
        where = 2 if where == 1 else 1
        source, target = target, (second if where == 1 else first)
