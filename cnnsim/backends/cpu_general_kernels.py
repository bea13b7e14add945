"""Compiled loops of the CPU backend's general road. Planes are (n, layers, rows, cols), see `cnnsim.backends.wiring`.

``around`` is (channels, n, rows + 2 r, cols + 2 r): every channel with its virtual cells.
"""

import math
from typing import Any

import numpy as np
from numba import prange
from numpy.typing import NDArray

from cnnsim.backends.cpu_compile import helper, twins
from cnnsim.backends.cpu_kernels import fill_virtual
from cnnsim.backends.wiring import CLIP, IDENTITY, SIGN, STEP_LEFT, STEP_RIGHT, TANH

Array = NDArray[Any]


@helper
def function_of(v: Any, kind: int, places: int, at: int, values: int, numbers: Array) -> Any:
    """Return a function at v, in v's precision; see `wiring.Function`."""
    if kind == IDENTITY:
        return v
    one = numbers.dtype.type(1)
    if kind == CLIP:
        scaled = v * numbers[at]
        return one if scaled > one else -one if scaled < -one else scaled
    if kind == SIGN:
        return one if v > 0 else -one if v < 0 else v
    if kind == TANH:
        return numbers.dtype.type(math.tanh(v * numbers[at]))
    i = 0
    if kind == STEP_LEFT:
        while i < places and v >= numbers[at + i]:
            i += 1
        return numbers[values + i]
    while i < places and v > numbers[at + i]:
        i += 1
    if kind == STEP_RIGHT:
        return numbers[values + i]
    if i == 0:
        return numbers[values]
    if i == places:
        return numbers[values + places - 1]
    rise = (numbers[values + i] - numbers[values + i - 1]) / (numbers[at + i] - numbers[at + i - 1])
    return numbers[values + i - 1] + rise * (v - numbers[at + i - 1])


@helper
def add_terms(
    total: Array, around: Array, links: Array, taps: Array, weights: Array, planes: Array, numbers: Array, layer: int,
    i: int, r: int,
) -> None:  # fmt: skip
    """Add all terms of a layer to row i of its drive; ``around`` is (channels, rows + 2 r, cols + 2 r)."""
    cols = total.size
    for t in range(links.shape[0]):
        target, neighbour, centre, times_neighbour, times_centre, first, after, kind, places, at, values = links[t]
        if target != layer:
            continue
        here = around[centre, i + r, r : r + cols]
        factor_here = around[times_centre, i + r, r : r + cols]
        for tap in range(first, after):
            row, col, plane = i + r + taps[tap, 0], r + taps[tap, 1], taps[tap, 2]
            there = around[neighbour, row, col : col + cols]
            weight = weights[tap]
            if centre < 0 and times_neighbour < 0 and kind == IDENTITY and plane < 0:
                for j in range(cols):
                    total[j] += weight * there[j]
                continue
            factor = around[times_neighbour, row, col : col + cols]
            for j in range(cols):
                v = there[j] - here[j] if centre >= 0 else there[j]
                f = function_of(v, kind, places, at, values, numbers)
                if times_neighbour >= 0:
                    f *= factor[j] - factor_here[j] if times_centre >= 0 else factor[j]
                total[j] += (planes[plane, i, j] if plane >= 0 else weight) * f


@twins
def fill_channel(around: Array, source: Array, rows: Array, cols: Array, r: int, constant: float) -> None:
    """Bring a plane (n, rows, cols) into a channel (n, rows + 2 r, cols + 2 r)."""
    n, height, width = source.shape
    for g in prange(n):
        around[g, r : r + height, r : r + width] = source[g]
        fill_virtual(around[g], rows, cols, r, constant)


@twins
def static_drive(
    w: Array, around: Array, links: Array, taps: Array, weights: Array, planes: Array, numbers: Array, r: int
) -> None:  # fmt: skip
    """Add the terms of the input alone to w."""
    n, layers, height, _ = w.shape
    for line in prange(n * layers * height):
        g, layer, i = line // (layers * height), line // height % layers, line % height
        add_terms(w[g, layer, i], around[:, g], links, taps, weights, planes, numbers, layer, i, r)


@twins
def drives(
    drive: Array, stage: Array, w: Array, past: Array, slots: Array, around: Array, moving: Array, layer_of: Array,
    outputs: Array, shape: Array, shape_numbers: Array, links: Array, taps: Array, weights: Array,
    planes: Array, numbers: Array, rows: Array, cols: Array, r: int, constant: float,
) -> None:  # fmt: skip
    """Write the drive of all layers in the state ``stage``.

    Of the channels, those numbered in ``moving`` follow the state: layer ``layer_of``, ``slots`` of the past (-1: the
    stage itself), through the characteristic ``shape`` where ``outputs`` says so.
    """
    n, layers, height, width = stage.shape
    kind, places, at, values = shape
    for line in prange(moving.size * n * height):
        m, g, i = line // (n * height), line // height % n, line % height
        source = stage[g, layer_of[m], i] if slots[m] < 0 else past[slots[m], g, layer_of[m], i]
        to = around[moving[m], g, i + r]
        if outputs[m]:
            for j in range(width):
                to[r + j] = function_of(source[j], kind, places, at, values, shape_numbers)
        else:
            for j in range(width):
                to[r + j] = source[j]
    for line in prange(moving.size * n):
        fill_virtual(around[moving[line // n], line % n], rows, cols, r, constant)
    for line in prange(n * layers * height):
        g, layer, i = line // (layers * height), line // height % layers, line % height
        row = drive[g, layer, i]
        row[:] = w[g, layer, i]
        add_terms(row, around[:, g], links, taps, weights, planes, numbers, layer, i, r)


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
    largest = np.zeros(n * layers * height, x.dtype)
    for line in prange(n * layers * height):
        g, layer, i = line // (layers * height), line // height % layers, line % height
        for j in range(width):
            slope = (drive[g, layer, i, j] - x[g, layer, i, j]) * rates[layer]
            against = wall and ((x[g, layer, i, j] >= 1 and slope > 0) or (x[g, layer, i, j] <= -1 and slope < 0))
            if not against and not (held.size and held[g, layer, i, j]):
                largest[line] = max(largest[line], abs(slope))
    return float(largest.max())


@twins
def discrete_step(
    out: Array, drive: Array, y: Array, shape: Array, shape_numbers: Array, held: Array
) -> float:  # fmt: skip
    """Write y(k + 1) = f(drive) and return the largest change; at a drive of 0 a sign keeps its old value."""
    n, layers, height, width = y.shape
    largest = np.zeros(n * layers * height, y.dtype)
    kind, places, at, values = shape
    for line in prange(n * layers * height):
        g, layer, i = line // (layers * height), line // height % layers, line % height
        for j in range(width):
            old, v = y[g, layer, i, j], drive[g, layer, i, j]
            keeps = (kind == SIGN and v == 0) or (held.size and held[g, layer, i, j])
            new = old if keeps else function_of(v, kind, places, at, values, shape_numbers)
            out[g, layer, i, j] = new
            largest[line] = max(largest[line], abs(new - old))
    return float(largest.max())
