"""Compiled loops of the CPU backend's general road. Planes are (n, layers, rows, cols), see `term_table`.

``around`` is (channels, n, rows + 2 r, cols + 2 r): every channel with its virtual cells. ``threads`` share the rows.
"""

from functools import cache
from typing import Any

import numba
import numpy as np
from numba import prange, types

from cnnsim.backends.codes import FunctionCode
from cnnsim.backends.cpu.jit.address import call, compiled_at
from cnnsim.backends.cpu.jit.compile import helper, twins
from cnnsim.backends.cpu.kernels import fill_virtual, most
from cnnsim.backends.cpu.term_rows import (
    add_one_step,
    add_product,
    add_weighted,
    copy_row,
    difference,
    function_row,
    functions,
    times_difference,
    times_row,
)
from cnnsim.support import Array

IDENTITY, SIGN, STEP = int(FunctionCode.IDENTITY), int(FunctionCode.SIGN), int(FunctionCode.STEP)
DRIVE, SLOPE, DISCRETE, EULER = range(4)
"""What `advance` does."""


@helper
def add_terms(
    function: int, room: Array, n: int, around: Array, shape: Any, g: int, layer: int, i: int, r: int, links: Array,
    taps: Array, weights: Array, planes: Array, numbers: Array,
) -> None:  # fmt: skip
    """Add all terms of a layer to row i of its drive in grid g: the first n cells of ``room``, which has three rows.

    ``around`` and ``planes`` are flat; ``shape`` is what ``around`` was.
    """
    _, grids, height, width = shape
    v, f, row_of_plane = n, 2 * n, (height - 2 * r) * n
    for t in range(links.shape[0]):
        target, neighbour, centre, times_neighbour, times_centre, first, after, kind, places, at, values = links[t]
        if target != layer:
            continue
        own = (i + r) * width + r
        here = (centre * grids + g) * height * width + own
        factor_here = (times_centre * grids + g) * height * width + own
        for tap in range(first, after):
            away = own + taps[tap, 0] * width + taps[tap, 1]
            there = (neighbour * grids + g) * height * width + away
            weight, plane = weights[tap], taps[tap, 2]
            if times_neighbour < 0 <= centre and plane < 0 and kind == STEP and places == 1:
                add_one_step(room, 0, weight, around, there, around, here, n, numbers[at], numbers[values],
                             numbers[values + 1])  # fmt: skip
                continue
            argument, at_argument = around, there
            if centre >= 0:
                difference(room, v, around, there, around, here, n)
                argument, at_argument = room, v
            result, at_result = argument, at_argument
            if kind != IDENTITY:
                function_row(function, room, f, argument, at_argument, n, kind, places, at, values, numbers)
                result, at_result = room, f
            if times_neighbour >= 0:
                if kind == IDENTITY:
                    copy_row(room, f, argument, at_argument, n)
                    result, at_result = room, f
                factor = (times_neighbour * grids + g) * height * width + away
                if times_neighbour == neighbour and times_centre == centre:
                    times_row(room, f, argument, at_argument, n)
                elif times_centre >= 0:
                    times_difference(room, f, around, factor, around, factor_here, n)
                else:
                    times_row(room, f, around, factor, n)
            if plane >= 0:
                add_product(room, 0, planes, plane * row_of_plane + i * n, result, at_result, n)
            else:
                add_weighted(room, 0, weight, result, at_result, n)


@twins
def fill_channel(around: Array, source: Array, rows: Array, cols: Array, r: int, constant: float) -> None:
    """Bring a plane (n, rows, cols) into a channel (n, rows + 2 r, cols + 2 r)."""
    n, height, width = source.shape
    for g in prange(n):
        for i in range(height):
            for j in range(width):
                around[g, r + i, r + j] = source[g, i, j]
        fill_virtual(around[g], rows, cols, r, constant)


@helper
def slots_of(ago: Array, number: int, kept: int, slots: Array) -> None:
    """Put down where in the past the states so many steps before ``number`` are; -1: now."""
    for m in range(ago.size):
        slots[m] = (number - ago[m]) % kept if ago[m] > 0 else -1


def listen(
    function: int, stage: Array, past: Array, number: int, keeps: bool, slots: Array, around: Array, moving: Array,
    layer_of: Array, outputs: Array, shape: Array, shape_numbers: Array, threads: int, thread: int, r: int,
) -> None:  # fmt: skip
    """Bring a thread's share of the rows of ``stage``, and of the past, into the channels that follow the state.

    Those are numbered in ``moving``: layer ``layer_of``, ``slots`` of the past (-1: the stage itself), through the
    characteristic ``shape`` where ``outputs`` says so. ``keeps``: ``stage`` becomes the past of step ``number``; nobody
    listens to that yet.
    """
    n, layers, height, width = stage.shape
    kind, places, at, values = shape
    now, before, to = stage.reshape(-1), past.reshape(-1), around.reshape(-1)
    if keeps:
        lines = n * layers * height
        first, after = thread * lines // threads * width, (thread + 1) * lines // threads * width
        copy_row(before, number % past.shape[0] * stage.size + first, now, first, after - first)
    lines, (_, _, tall, wide) = moving.size * n * height, around.shape
    for line in range(thread * lines // threads, (thread + 1) * lines // threads):
        m, g, i = line // (n * height), line // height % n, line % height
        source = ((g * layers + layer_of[m]) * height + i) * width
        out = ((moving[m] * n + g) * tall + i + r) * wide + r
        whole = now
        if slots[m] >= 0:
            whole, source = before, slots[m] * stage.size + source
        if outputs[m]:
            function_row(function, to, out, whole, source, width, kind, places, at, values, shape_numbers)
        else:
            copy_row(to, out, whole, source, width)


def do_lines(
    function: int, task: int, out: Array, largest: Array, x: Array, gains: Array, held: Array, wall: bool, threads: int,
    thread: int, room: Array, w: Array, around: Array, shape: Array, shape_numbers: Array, r: int, links: Array,
    taps: Array, weights: Array, planes: Array, numbers: Array,
) -> None:  # fmt: skip
    """Do a task of `advance` with a thread's share of the rows."""
    n, layers, height, width = x.shape
    lines, one = n * layers * height, x.dtype.type(1)
    heard, weights_of_cells, constant_drive = around.reshape(-1), planes.reshape(-1), w.reshape(-1)
    kind, places, at, values = shape
    for line in range(thread * lines // threads, (thread + 1) * lines // threads):
        g, layer, i = line // (layers * height), line // height % layers, line % height
        copy_row(room, 0, constant_drive, line * width, width)
        add_terms(
            function, room, width, heard, around.shape, g, layer, i, r, links, taps, weights, weights_of_cells, numbers
        )
        drive, new, old, gain = room[:width], out[g, layer, i], x[g, layer, i], gains[layer]
        still = held[g, layer, i] if held.size else held[0, 0, 0]
        if task == DRIVE:
            for j in range(width):
                new[j] = drive[j]
        elif task == SLOPE:
            for j in range(width):
                new[j] = drive[j] - old[j]
        elif task == DISCRETE:
            function_row(function, room, width, room, 0, width, kind, places, at, values, shape_numbers)
            change = x.dtype.type(0)
            for j in range(width):
                keeps = (kind == SIGN and drive[j] == 0) or (still.size and still[j])
                new[j] = old[j] if keeps else room[width + j]
                change = max(change, abs(new[j] - old[j]))
            largest[line] = change
        else:
            for j in range(width):
                drive[j] = old[j] + gain * (drive[j] - old[j])
            if wall:
                for j in range(width):
                    v = one if drive[j] > one else drive[j]
                    drive[j] = -one if v < -one else v
            for j in range(still.size):
                drive[j] = old[j] if still[j] else drive[j]
            for j in range(width):
                old[j] = drive[j]


@cache
def shared(dtype: np.dtype[Any]) -> tuple[Any, Any, Any]:
    """Return `functions`, `listen` and `do_lines` compiled for a dtype: `advance` calls them by address."""
    cells, integer, whole, truth = numba.from_dtype(dtype), types.int64, types.int64[::1], types.boolean
    row, planes, past = (types.Array(cells, dimensions, "C") for dimensions in (1, 4, 5))
    links, truths, held = types.int64[:, ::1], types.boolean[::1], types.Array(truth, 4, "C")
    listening = types.void(
        integer,
        planes,
        past,
        integer,
        truth,
        whole,
        planes,
        whole,
        whole,
        truths,
        whole,
        row,
        integer,
        integer,
        integer,
    )
    doing = types.void(
        integer, integer, planes, row, planes, row, held, truth, integer, integer, row, planes, planes, whole, row,
        integer, links, links, row, types.Array(cells, 3, "C"), row,
    )  # fmt: skip
    return functions(dtype), compiled_at(listen, listening), compiled_at(do_lines, doing)


@twins
def advance(
    function: int, listen_at: int, do_lines_at: int, task: int, out: Array, largest: Array, x: Array, first: int,
    count: int, ago: Array, gains: Array, held: Array, wall: bool, threads: int, w: Array, past: Array, around: Array,
    moving: Array, layer_of: Array, outputs: Array, shape: Array, shape_numbers: Array, rows: Array, cols: Array,
    constant: float, r: int, links: Array, taps: Array, weights: Array, planes: Array, numbers: Array,
) -> None:  # fmt: skip
    """Do a task with the drives of all layers in the state x, ``count`` times, from step ``first`` on.

    DRIVE writes them to ``out``, SLOPE the drives less the state. DISCRETE writes the outputs that they make, the old
    one where a cell is held or the drive of a sign is 0, and the largest change of each row to ``largest``. EULER takes
    steps of a one-stage scheme in place: once all channels are filled nobody reads x but the cell itself, so a row may
    be replaced when it is done. One loop for all four, because it is long to compile.
    """
    n, width = x.shape[0], x.shape[3]
    rooms, slots = np.empty((threads, 3 * width), x.dtype), np.empty(ago.size, np.int64)
    keeps = task == EULER and past.shape[0] > 1
    for number in range(first, first + count):
        slots_of(ago, number, past.shape[0], slots)
        for thread in prange(threads):
            call(listen_at, (function, x, past, number, keeps, slots, around, moving, layer_of, outputs, shape,
                             shape_numbers, threads, thread, r))  # fmt: skip
        for line in prange(moving.size * n):
            fill_virtual(around[moving[line // n], line % n], rows, cols, r, constant)
        for thread in prange(threads):
            call(do_lines_at, (function, task, out, largest, x, gains, held, wall, threads, thread, rooms[thread], w,
                               around, shape, shape_numbers, r, links, taps, weights, planes, numbers))  # fmt: skip


@twins
def combine(
    out: Array, x: Array, slopes: Array, gains: Array, weights: Array, held: Array, wall: bool
) -> None:  # fmt: skip
    """Write x + gain of its layer * sum of weight * slope; held cells (if there are any) keep x."""
    n, layers, height, width = x.shape
    one = x.dtype.type(1)
    for line in prange(n * layers * height):
        g, layer, i = line // (layers * height), line // height % layers, line % height
        to, row = out[g, layer, i], x[g, layer, i]
        for j in range(width):
            v = row[j]
            if not (held.size and held[g, layer, i, j]):
                total = x.dtype.type(0)
                for s in range(weights.size):
                    total += weights[s] * slopes[s, g, layer, i, j]
                v += gains[layer] * total
                if wall:
                    v = one if v > one else -one if v < -one else v
            to[j] = v


@twins
def steepest_of(
    drive: Array, x: Array, rates: Array, held: Array, wall: bool
) -> float:  # fmt: skip
    """Return the largest |dx/dt| of the free cells."""
    n, layers, height, width = x.shape
    largest = np.empty(n * layers * height, x.dtype)
    for line in prange(n * layers * height):
        g, layer, i = line // (layers * height), line // height % layers, line % height
        largest[line] = 0
        for j in range(width):
            slope = (drive[g, layer, i, j] - x[g, layer, i, j]) * rates[layer]
            against = wall and ((x[g, layer, i, j] >= 1 and slope > 0) or (x[g, layer, i, j] <= -1 and slope < 0))
            if not against and not (held.size and held[g, layer, i, j]):
                largest[line] = max(largest[line], abs(slope))
    return float(most(largest))
