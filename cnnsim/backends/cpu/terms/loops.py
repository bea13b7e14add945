"""Compiled loops over the tiles of networks of terms. Planes are (n, layers, rows, cols), see `term_table`."""

from functools import cache
from typing import Any

import numba
import numpy as np
from numba import prange, types

from cnnsim.backends.cpu.jit.address import call, compiled_at
from cnnsim.backends.cpu.jit.columns import records
from cnnsim.backends.cpu.jit.compile import twins
from cnnsim.backends.cpu.terms.function_rows import functions
from cnnsim.backends.cpu.terms.groups import ChannelColumns, Layers, StageTable, Surround, TermArrays, TermPlanes
from cnnsim.backends.cpu.terms.layout import term_cells
from cnnsim.backends.cpu.terms.tile import step_tile
from cnnsim.backends.cpu.tiles.grid import Area, tile_area
from cnnsim.backends.term_table import TapColumns, TermColumns
from cnnsim.support import Array

APART = 32
"""Numbers between what two threads write to: they must not share a line of the cache."""


@cache
def called(dtype: np.dtype[Any]) -> tuple[Any, Any]:
    """Return `functions` and `step_tile` compiled for a dtype: they are called by their addresses."""
    row, plane, states = np.empty(0, dtype), np.empty((0, 0, 0, 0), dtype), np.empty((0, 0, 0, 0, 0), dtype)
    whole, zero = np.empty(0, np.int64), dtype.type(0)
    terms, taps = TermColumns(*len(TermColumns._fields) * [whole]), TapColumns(whole, whole, whole, row)
    channels, integer = ChannelColumns(whole, whole, whole, whole > 0), types.int64
    planes, how, stages, characteristic, field, edge, area, numbers = map(numba.typeof, (
        (plane, states, states, plane, np.empty((0, 0, 0), np.uint64)), (row, True), (row, whole, True),
        (0, 0, 0, 0, row), (records(channels), records(terms), records(taps), row, row), (0, 0, zero, zero),
        Area(0, 0, 0, 0), row,
    ))  # fmt: skip
    step = types.void(
        integer, integer, integer, planes, how, stages, characteristic, field, edge, integer, area, integer, integer,
        numbers, numbers, numbers,
    )  # fmt: skip
    return functions(dtype), compiled_at(step_tile, step)


@twins
def advance(
    run: tuple[int, int, int, int, int, int, int], how: Layers, stages: StageTable, characteristic: Any,
    field: TermArrays, edge: Surround, planes: TermPlanes, found: Array, job: tuple[int, int, int, int, int],
) -> None:  # fmt: skip
    """Do a task with the drives of all layers: the ``job`` (task, first, count, tile, after).

    It is done in ``count`` steps from step ``first`` on, with the tiles from ``tile`` on.

    ``run`` are the addresses of `called`, the number of threads, rows and columns of a tile, the most columns that come
    with it, and the rows of a low torus (else 0). DRIVE adds all terms to w. STEP takes
    steps of a scheme, each from the states k to the states k + 1. DISCRETE writes the outputs that the drives make, the
    old one where a mask holds it or the drive of a sign is 0. ``found`` has a row for each thread: of DISCRETE the
    largest change, of CHECK the largest |drive - x| of the free cells of each layer.
    """
    function, tile_at, threads, height, wide, width, low = run
    n, layers, rows, cols = planes[0].shape
    task, first, count, tile, after = job
    size = term_cells(stages[1].size, stages[2], layers, field[0].size, edge[0], low, width)
    scratches = np.empty((threads, size), found.dtype)
    for number in range(first, first + count):
        for thread in prange(threads):
            for each in range(tile + thread * (after - tile) // threads,
                              tile + (thread + 1) * (after - tile) // threads):  # fmt: skip
                g, area = tile_area(each, (n, rows, cols), height, wide)
                call(tile_at, (function, task, number, planes, how, stages, characteristic, field, edge, g, area, width,
                               low, scratches[thread], scratches[thread], found[thread]))  # fmt: skip
