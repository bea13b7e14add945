"""Part of a grid, checked or caught up as where tiles sleep: for grids that are computed in blocks."""

import numpy as np

from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import twins
from cnnsim.backends.cpu.tiles.grid import Area, Feedback
from cnnsim.backends.cpu.tiles.scratch import clear
from cnnsim.backends.cpu.tiles.settled import C0, C1, FIGURES, R0, R1, RATE, UNSATURATED, start_check
from cnnsim.backends.cpu.tiles.window import window_cells, window_layout
from cnnsim.support import Array

HEIGHT, WIDTH = 32, 256
"""Cells of a window: its rows stay in the second cache."""


@twins
def over_part(
    planes: tuple[Array, Array, Array], feedback: Feedback, address: int, area: Area, task: int, behind: int,
    rest: float,
) -> tuple[float, bool, tuple[int, int, int, int]]:  # fmt: skip
    """Do a task of `window.step_window` with the cells of ``area`` in all grids of ``planes``: x, target and w.

    Of a check it returns the largest |dx/dt|, whether all cells are saturated for good, and where the others lie.
    """
    x, target, w = planes
    r = feedback[4]
    scratch = np.empty(window_cells(HEIGHT, 0, r), x.dtype)
    clear(scratch, WIDTH + 4 * r)
    at, all_found = window_layout(scratch, HEIGHT, 0, r), np.empty((1, FIGURES))
    found = all_found[0]
    start_check(found)
    for g in range(x.shape[0]):
        for r0 in range(area[0], area[1], HEIGHT):
            for c0 in range(area[2], area[3], WIDTH):
                part = Area(r0, min(r0 + HEIGHT, area[1]), c0, min(c0 + WIDTH, area[3]))
                call(address, (x[g], w[g], target[g], feedback, 0, part, scratch, at, task, rest, True, behind,
                               all_found))  # fmt: skip
    still = found[UNSATURATED] == 0
    if still:
        return found[RATE], True, (0, 0, 0, 0)
    return found[RATE], False, (int(found[R0]), int(found[R1]), int(found[C0]), int(found[C1]))
