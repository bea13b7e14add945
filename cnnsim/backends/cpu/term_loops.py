"""Compiled loops over the cells of a network of terms. Planes are (n, layers, rows, cols), see `term_table`."""

from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import prange, types

from cnnsim.backends.codes import NOTHING, FunctionCode, TaskCode
from cnnsim.backends.cpu.boundary import VirtualCells, fill_beside, fill_virtual, fill_virtual_rows, virtual_cells
from cnnsim.backends.cpu.function_rows import copy_row, function_row, functions
from cnnsim.backends.cpu.jit.address import bare, call, compiled_at
from cnnsim.backends.cpu.jit.columns import records
from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.backends.cpu.term_rows import SCRATCH_ROWS, add_terms
from cnnsim.backends.term_table import TapColumns, TermColumns
from cnnsim.network import ZERO_FLUX
from cnnsim.support import Array

SIGN = int(FunctionCode.SIGN)
DRIVE, RATE, DISCRETE, EULER, CHECK = map(int, TaskCode)
NO_MASK = np.empty((1, 1, 1, 0), bool)
"""The mask that holds no cell."""
APART = 32
"""Numbers between what two threads write to: they must not share a line of the cache."""


# Groups of parameters; Python hands them over as bare tuples (see `prepared`).


class TermArrays(NamedTuple):
    """Terms and what they are of: ``padded`` (channels, n, rows + 2 r, cols + 2 r) is every channel with its
    `VirtualCells`; ``terms`` and ``taps`` are the records of a `TermTable`, ``planes`` and ``numbers`` its own.
    """

    padded: Array
    terms: Array
    taps: Array
    planes: Array
    numbers: Array


class Cells(NamedTuple):
    """How layers step: their ``gains``; a ``mask`` without cells holds none; ``limited``: states stay within +-1."""

    gains: Array
    mask: Array
    limited: bool


class Planes(NamedTuple):
    """What a task reads and writes: ``largest`` is a number for every row, ``past`` (steps, n, layers, rows, cols)."""

    out: Array
    largest: Array
    x: Array
    w: Array
    past: Array


class Following(NamedTuple):
    """Channels that follow the state: their number, layer, delay in steps, and whether they are outputs."""

    channel: Array
    layer: Array
    ago: Array
    output: Array


@twins
def fill_channel(padded: Array, source: Array, virtual: VirtualCells) -> None:
    """Copy a plane (n, rows, cols) into a channel (n, rows + 2 r, cols + 2 r)."""
    n, height, width = source.shape
    r = virtual[2]
    for g in prange(n):
        for i in range(height):
            for j in range(width):
                padded[g, r + i, r + j] = source[g, i, j]
        fill_virtual(padded[g], virtual)


@helper
def find_slots(following: Array, number: int, kept: int, slots: Array) -> None:
    """Find where in the past the states are that channels follow in step ``number``; NOTHING: the present one."""
    for m in range(following.size):
        ago = following[m]["ago"]
        slots[m] = (number - ago) % kept if ago > 0 else NOTHING


def fill_channels(
    function: int, stage: Array, past: Array, number: int, keeps: bool, slots: Array, padded: Array, following: Array,
    characteristic: Any, threads: int, thread: int, virtual: VirtualCells,
) -> None:  # fmt: skip
    """Copy a thread's share of the rows of ``stage``, and of the past, into the channels that follow the state.

    They are the rows whose terms the thread adds up afterwards: what another core has written is slow to read.
    ``slots`` are places in the past (NOTHING: the stage itself). ``keeps``: ``stage`` becomes the past of step
    ``number``, which no channel follows yet.
    """
    n, layers, height, width = stage.shape
    kind, places, at, values, numbers = characteristic
    now, before, to, numbers = bare(stage), bare(past), bare(padded), bare(numbers)
    if keeps:
        lines = n * layers * height
        first, after = thread * lines // threads * width, (thread + 1) * lines // threads * width
        copy_row(before, number % past.shape[0] * stage.size + first, now, first, after - first)
    lines, (_, _, tall, wide) = n * height, padded.shape
    rows, cols, r, constant = virtual
    beside = bare(rows), bare(cols), r, constant
    for line in range(thread * lines // threads, (thread + 1) * lines // threads):
        g, i = line // height, line % height
        for m in range(following.size):
            source = ((g * layers + following[m]["layer"]) * height + i) * width
            out = ((following[m]["channel"] * n + g) * tall + i + r) * wide
            whole = now
            if slots[m] >= 0:
                whole, source = before, slots[m] * stage.size + source
            if following[m]["output"]:
                function_row(function, to, out + r, whole, source, width, kind, places, at, values, numbers)
            else:
                copy_row(to, out + r, whole, source, width)
            fill_beside(to, out, width, beside)


def run_rows(
    function: int, task: int, planes: Planes, cells: Cells, characteristic: Any, field: TermArrays, r: int,
    scratch: Array, first: int, after: int,
) -> None:  # fmt: skip
    """Do a task of `advance` with the rows from ``first`` on, counted through all layers of a row and all grids."""
    out, largest, x, w, _ = planes
    gains, mask, limited = cells
    padded, terms, taps, weights, term_numbers = field
    kind, places, at, values, numbers = characteristic
    _, layers, height, width = x.shape
    one = x.dtype.type(1)
    scratch, flat, flat_weights, constant_drive = bare(scratch), bare(padded), bare(weights), bare(w)
    term_numbers, numbers, gains = bare(term_numbers), bare(numbers), bare(gains)
    states, results, held = bare(x), bare(out), bare(mask)
    terms, taps = bare(terms), bare(taps)
    for j in range((SCRATCH_ROWS - 1) * width, SCRATCH_ROWS * width):
        scratch[j] = 0
    for line in range(first, after):
        g, layer, i = line // (layers * height), line % layers, line // layers % height
        cell = ((g * layers + layer) * height + i) * width
        copy_row(scratch, 0, constant_drive, cell, width)
        add_terms(function, scratch, (g, layer, i), flat, padded.shape, r, terms, taps, flat_weights, term_numbers)
        drive, new, old = scratch[:width], results[cell : cell + width], states[cell : cell + width]
        gain, still = gains[layer], held[cell : cell + width if held.size else cell]
        if task == DRIVE:
            for j in range(width):
                new[j] = drive[j]
        elif task == RATE:
            for j in range(width):
                new[j] = drive[j] - old[j]
        elif task == DISCRETE:
            function_row(function, scratch, width, scratch, 0, width, kind, places, at, values, numbers)
            change = x.dtype.type(0)
            for j in range(width):
                keeps = (kind == SIGN and drive[j] == 0) or (still.size and still[j])
                new[j] = old[j] if keeps else scratch[width + j]
                change = max(change, abs(new[j] - old[j]))
            largest[line] = change
        elif task == CHECK:
            rate = x.dtype.type(0)
            for j in range(width):
                change = drive[j] - old[j]
                against = limited and ((old[j] >= 1 and change > 0) or (old[j] <= -1 and change < 0))
                if not against and not (still.size and still[j]):
                    rate = max(rate, abs(change))
            largest[line] = rate
        else:
            for j in range(width):
                drive[j] = old[j] + gain * (drive[j] - old[j])
            if limited:
                for j in range(width):
                    v = one if drive[j] > one else drive[j]
                    drive[j] = -one if v < -one else v
            for j in range(still.size):
                drive[j] = old[j] if still[j] else drive[j]
            for j in range(width):
                old[j] = drive[j]


@cache
def called(dtype: np.dtype[Any]) -> tuple[Any, Any, Any]:
    """Return `functions`, `fill_channels` and `run_rows` compiled for a dtype: `advance` calls them by address."""
    row, plane, past = np.empty(0, dtype), np.empty((0, 0, 0, 0), dtype), np.empty((0, 0, 0, 0, 0), dtype)
    empty = np.empty(0, np.int64)
    terms, taps = TermColumns(*len(TermColumns._fields) * [empty]), TapColumns(empty, empty, empty, row)
    integer = types.int64
    planes, cells, following, characteristic, field = map(numba.typeof, (
        (plane, row, plane, plane, past), (row, NO_MASK, True), records(Following(empty, empty, empty, empty > 0)),
        (0, 0, 0, 0, row), (plane, records(terms), records(taps), np.empty((0, 0, 0), dtype), row),
    ))  # fmt: skip
    fill = types.void(
        integer, planes[2], planes[4], integer, types.boolean, types.int64[::1], field[0], following, characteristic,
        integer, integer, numba.typeof(virtual_cells((1, 1), 0, ZERO_FLUX, dtype.type(0))),
    )  # fmt: skip
    run = types.void(
        integer, integer, planes, cells, characteristic, field, integer, numba.typeof(row), integer, integer
    )  # fmt: skip
    return functions(dtype), compiled_at(fill_channels, fill), compiled_at(run_rows, run)


@twins
def advance(
    run: tuple[int, int, int, int], cells: Cells, following: Array, characteristic: Any, field: TermArrays,
    virtual: VirtualCells, planes: Planes, job: tuple[int, int, int, int, int],
) -> None:  # fmt: skip
    """Do a task with the drives of all layers in the state x: the ``job`` (task, first, count, row, after).

    It is done in ``count`` steps from step ``first`` on, with the rows from ``row`` on. Of jobs of some of the rows,
    each with one step, those that begin at row 0 fill the channels.

    ``run`` are the addresses of `called` and the number of threads. DRIVE writes the drives to ``out``, RATE the drives
    less the state. DISCRETE writes the outputs that they make, the old one where a mask holds it or the drive of a sign
    is 0, and the largest change of each row to ``largest``; CHECK the largest |drive - x| of its free cells. EULER
    takes steps of a one-stage scheme in place: once all channels are filled only the cell itself reads x, so a row may
    be replaced when it is done. One loop for all five, because it is long to compile.
    """
    function, fill_at, run_at, threads = run
    _, _, x, _, past = planes
    padded, (task, first, count, row, after) = field[0], job
    n, width, r = x.shape[0], x.shape[3], virtual[2]
    scratches, slots = np.empty((threads, SCRATCH_ROWS * width + APART), x.dtype), np.empty(following.size, np.int64)
    keeps = task == EULER and past.shape[0] > 1
    for number in range(first, first + count):
        if row == 0:
            find_slots(following, number, past.shape[0], slots)
            for thread in prange(threads):
                call(fill_at, (function, x, past, number, keeps, slots, padded, following, characteristic, threads,
                               thread, virtual))  # fmt: skip
            for line in prange(following.size * n):
                fill_virtual_rows(padded[following[line // n]["channel"], line % n], virtual)
        for thread in prange(threads):
            mine, next_one = row + thread * (after - row) // threads, row + (thread + 1) * (after - row) // threads
            call(run_at, (function, task, planes, cells, characteristic, field, r, scratches[thread], mine,
                          next_one))  # fmt: skip
