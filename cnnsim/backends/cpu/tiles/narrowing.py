"""Euler steps of which only an area is wanted: each pass over the grid leaves out what can reach it no more."""

import numpy as np

from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import kernel
from cnnsim.backends.cpu.tiles.grid import Area, Feedback
from cnnsim.backends.cpu.tiles.scratch import clear, tile_cells, tile_layout
from cnnsim.backends.cpu.tiles.settled import FIGURES
from cnnsim.support import Array


@kernel
def pass_over(
    planes: tuple[Array, Array, Array], feedback: Feedback, address: int, tile: tuple[int, int], steps: int, area: Area
) -> None:
    """Take some steps of the cells of ``area`` in all grids of ``planes``: x, target and w.

    ``address`` is that of `tile.stream`, ``tile`` the rows and columns that it takes at a time.
    """
    x, target, w = planes
    r, (height, width), (top, bottom, left, right) = feedback[4], tile, area
    lives, no_mask = feedback[8], np.empty((0, 0), np.uint64)
    scratch, found = np.empty(tile_cells(steps, r, lives), x.dtype), np.empty(FIGURES)
    clear(scratch, width + 2 * steps * r)
    at = tile_layout(scratch, steps, r, lives)
    for g in range(x.shape[0]):
        for r0 in range(top, bottom, height):
            for c0 in range(left, right, width):
                part = Area(r0, min(r0 + height, bottom), c0, min(c0 + width, right))
                call(
                    address,
                    (x[g], w[g], no_mask, target[g], feedback, steps, part, scratch, at, False, 0.0, False, found),
                )
