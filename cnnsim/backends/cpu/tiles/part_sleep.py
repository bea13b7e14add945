"""Euler steps of which only an area is wanted, taken in tiles that sleep while no output in them can change.

As `cnnsim.backends.cpu.tiles.sleep`, for one thread and a known number of steps. What lies beyond the plane is not
known here, so from its edges inwards states become wrong by r cells a step: an unsaturated cell counts only while what
it changes can still come to the area.
"""

import numpy as np

from cnnsim.backends.cpu.jit.address import call
from cnnsim.backends.cpu.jit.compile import helper, kernel
from cnnsim.backends.cpu.tiles.boundary import is_periodic
from cnnsim.backends.cpu.tiles.grid import Area, Feedback, tile_area
from cnnsim.backends.cpu.tiles.scratch import clear, move, tile_cells, tile_layout
from cnnsim.backends.cpu.tiles.settled import C0, C1, FIGURES, R0, R1, UNSATURATED, start_check
from cnnsim.backends.cpu.tiles.sleep import CHOSEN, UPTO, WIDTH, choose, wake
from cnnsim.backends.cpu.tiles.tiled import TILE_COLS, TILE_ROWS
from cnnsim.backends.cpu.tiles.window import CATCH_UP, CHECK, HEIGHT, window_cells, window_layout
from cnnsim.support import Array

Planes = tuple[Array, Array, Array]
"""States of n grids, a plane of them for the tiles of a pass, and drives w."""
TAKEN = 2
"""Of a chosen tile: it has been stepped with one before it."""
MOST_HIGH, MOST_WIDE = TILE_ROWS // HEIGHT, TILE_COLS // WIDTH
"""Tiles down and across that are stepped as one: a rectangle of them takes less around it than each by itself."""


@kernel
def look(planes: Planes, feedback: Feedback, address: int, tiles: Array, first: int, every: int) -> float:
    """Check one tile in so many, from the ``first`` on; return which share of them has an unsaturated cell."""
    x, spare, w = planes
    scratch = np.empty(window_cells(HEIGHT, 0, feedback[4]), x.dtype)
    clear(scratch, WIDTH + 4 * feedback[4])
    at, restless, looked = window_layout(scratch, HEIGHT, 0, feedback[4]), 0, 0
    for tile in range(first, tiles.shape[0], every):
        g, area = tile_area(tile, x.shape, HEIGHT, WIDTH)
        start_check(tiles[tile])
        found = tiles[tile : tile + 1]
        call(address, (x[g], w[g], spare[g], feedback, 0, area, scratch, at, CHECK, 0.0, False, 0, found))
        looked += 1
        restless += tiles[tile, UNSATURATED] > 0
    return restless / max(looked, 1)


@kernel
def step_awake(
    planes: Planes, feedback: Feedback, addresses: tuple[int, int], tiles: Array, done: int, steps: int, counts: Area
) -> None:
    """Take ``steps`` of the tiles that an unsaturated cell among those in the area ``counts`` can reach meanwhile.

    ``addresses`` are those of `window.step_window` and of `tile.stream`.
    """
    x, target, w = planes
    (address, streaming), r, lives, no_mask = addresses, feedback[4], feedback[8], np.empty((0, 0), np.uint64)
    scratch, rows = np.empty(window_cells(HEIGHT, 0, r), x.dtype), np.empty(tile_cells(steps, r, lives), x.dtype)
    clear(scratch, WIDTH + 4 * r)
    clear(rows, MOST_WIDE * WIDTH + 2 * steps * r)
    at, at_rows = window_layout(scratch, HEIGHT, 0, r), tile_layout(rows, steps, r, lives)
    _forget(tiles, counts)
    choose(tiles, False)
    wake(tiles, steps * r, x.shape, is_periodic(feedback[4:7]), False)
    for tile in range(tiles.shape[0]):  # before any is stepped: neighbours take their states on
        if tiles[tile, CHOSEN]:
            _catch_up(planes, feedback, address, tiles, tile, done, scratch, at)
    for tile in range(tiles.shape[0]):
        if tiles[tile, CHOSEN] == 1:
            g, part = _together(tiles, tile, x.shape)
            call(streaming, (x[g], w[g], no_mask, target[g], feedback, steps, part, rows, at_rows, False, 0.0, False,
                             tiles[tile, :FIGURES]))  # fmt: skip
    for tile in range(tiles.shape[0]):
        if tiles[tile, CHOSEN]:
            g, area = tile_area(tile, x.shape, HEIGHT, WIDTH)
            for i in range(area.r0, area.r1):
                move(target[g, i], area.c0, x[g, i], area.c0, area.c1 - area.c0)
            tiles[tile, UPTO] = done + steps
    for tile in range(tiles.shape[0]):
        if tiles[tile, CHOSEN]:
            g, area = tile_area(tile, x.shape, HEIGHT, WIDTH)
            start_check(tiles[tile])
            found = tiles[tile : tile + 1]
            call(address, (x[g], w[g], x[g], feedback, 0, area, scratch, at, CHECK, 0.0, False, 0, found))


@helper
def _together(tiles: Array, first: int, shape: tuple[int, int, int]) -> tuple[int, Area]:
    """Return the grid and the cells of the chosen tiles that make a rectangle with this one; they count as taken."""
    across, (g, a) = (shape[2] + WIDTH - 1) // WIDTH, tile_area(first, shape, HEIGHT, WIDTH)
    wide, high, last = 1, 1, (g + 1) * ((shape[1] + HEIGHT - 1) // HEIGHT) * across
    while wide < MOST_WIDE and first % across + wide < across and tiles[first + wide, CHOSEN] == 1:
        wide += 1
    while high < MOST_HIGH and first + high * across < last:
        free = 0
        for k in range(wide):
            free += tiles[first + high * across + k, CHOSEN] == 1
        if free < wide:
            break
        high += 1
    for down in range(high):
        for k in range(wide):
            tiles[first + down * across + k, CHOSEN] = TAKEN
    return g, Area(a.r0, min(shape[1], a.r0 + high * HEIGHT), a.c0, min(shape[2], a.c0 + wide * WIDTH))


@kernel
def all_caught_up(planes: Planes, feedback: Feedback, address: int, tiles: Array, done: int, wanted: Area) -> None:
    """Take all tiles that have cells in the area ``wanted`` to a step."""
    scratch = np.empty(window_cells(HEIGHT, 0, feedback[4]), planes[0].dtype)
    clear(scratch, WIDTH + 4 * feedback[4])
    at, (r0, r1, c0, c1) = window_layout(scratch, HEIGHT, 0, feedback[4]), wanted
    for tile in range(tiles.shape[0]):
        _, area = tile_area(tile, planes[0].shape, HEIGHT, WIDTH)
        if area.r0 < r1 and area.r1 > r0 and area.c0 < c1 and area.c1 > c0:
            _catch_up(planes, feedback, address, tiles, tile, done, scratch, at)


@helper
def _catch_up(
    planes: Planes, feedback: Feedback, address: int, tiles: Array, tile: int, done: int, scratch: Array, at: Area
) -> None:
    """Take a tile, in its place, to a step up to which all outputs in and around it stood still."""
    (x, _, w), missed = planes, done - int(tiles[tile, UPTO])
    if missed > 0:
        g, area = tile_area(tile, x.shape, HEIGHT, WIDTH)
        found = tiles[tile : tile + 1]
        call(address, (x[g], w[g], x[g], feedback, 0, area, scratch, at, CATCH_UP, 0.0, False, missed, found))
        tiles[tile, UPTO] = done


@helper
def _forget(tiles: Array, counts: Area) -> None:
    """Take cells for saturated that are not in an area."""
    for tile in range(tiles.shape[0]):
        found = tiles[tile]
        found[R0], found[R1] = max(found[R0], counts[0]), min(found[R1], counts[1])
        found[C0], found[C1] = max(found[C0], counts[2]), min(found[C1], counts[3])
        if not (found[R0] < found[R1] and found[C0] < found[C1]):
            found[UNSATURATED] = 0
