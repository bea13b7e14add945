"""Tiles in which the terms of a network are summed: the constants of the loops, and the loop over steps and tiles."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numba
import numpy as np
from numba import prange, types

from cnnsim.backends.codes import NOTHING, FunctionCode, TaskCode, boundary_code
from cnnsim.backends.cpu.compiled import call, compiled_at, records, threads_for, twins
from cnnsim.backends.cpu.tiles.functions import functions
from cnnsim.backends.cpu.tiles.grid import tile_area
from cnnsim.backends.cpu.tiles.stage_rows import LiveRows
from cnnsim.backends.cpu.tiles.term_sums import WorkRows
from cnnsim.backends.cpu.tiles.term_tile import Job, TermPlanes, TermRule, step_tile, tile_sizes
from cnnsim.backends.slices import PIECE, TERM, pieces
from cnnsim.backends.term_table import Function, TapColumns, TermColumns, TermTable
from cnnsim.network.frames import at_step
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import Scheme
from cnnsim.support import Array

WIDE, HIGH = 1024, 512
"""The most columns and rows of a tile."""
LEAST = 8
"""The fewest rows of a tile: a lower one would load as many rows around it."""
LOW = 32
"""Rows and columns of a torus up to which all its rows stay in the cache: more cells would lie around it than in it."""
APART = 32
"""Distance between numbers that two threads write: they must not share a cache line."""
FOUND = 2
"""Results in addition to one for each layer: see `step_tile`."""


@cache
def step_of(dtype: np.dtype[Any]) -> Any:
    """Return `step_tile` compiled for a dtype."""
    none, row, zero = np.empty(0, np.int64), np.empty(0, dtype), dtype.type(0)
    plane, later = np.empty((1, 0, 0, 0), dtype), np.empty((1, 1, 0, 0, 0), dtype)
    terms = TermColumns(*len(TermColumns._fields) * [none])
    table = TermTable((), terms, TapColumns(none, none, none, row), plane[0], row, 0)
    rule = _rule(table, _channel_records(table, outputs=True), (row, True, row, none, True), (0, row, row),
                 (0, 0, zero, zero, 0))  # fmt: skip
    planes = plane, later, later, plane, plane > 0
    live = LiveRows(plane[0], plane[0], plane[0], plane[0] > 0, plane[0])
    given = Job(*8 * [0]), planes, (0, 0, *rule), live, plane[0], WorkRows(row, row, row, row, row, row > 0, row), row
    return compiled_at(step_tile, types.void(*map(numba.typeof, given)))


@twins
def advance(
    planes: TermPlanes, rule: TermRule, tiles: tuple[int, int, int, int, int], found: Array,
    task: tuple[int, int, int, int, int],
) -> None:  # fmt: skip
    """Do a ``task`` (its code, the number of the state, how many steps, the first tile, the one after the last).

    ``tiles``: threads, rows and columns of a tile, most columns with those around it, steps a pass. DRIVE adds all
    terms to w. STEP goes from the state k to the state k + 1 in each pass. DISCRETE writes the outputs that the drives
    make. CHECK writes nothing. ``found`` has a row for each thread.
    """
    threads, height, wide, width, depth = tiles
    code, number, count, tile, after = task
    n, layers, rows, cols = planes[0].shape
    live, kept, ring, stride = tile_sizes(rule, width, depth)
    lives = np.empty((3, threads, layers, live, stride), found.dtype)
    rates = np.empty((threads, layers, live * kept, stride), found.dtype)
    rings = np.empty((threads, depth * rule[5].size, rule[10].size, (ring + 1) * stride), found.dtype)
    work, masks = np.empty((threads, 6, stride), found.dtype), np.empty((threads, layers, live + 1, stride), np.bool_)
    while count > 0:
        steps = min(depth, count)
        for thread in prange(threads):
            of = work[thread]
            live_rows = LiveRows(lives[0, thread], lives[1, thread], lives[2, thread], masks[thread], rates[thread])
            rows_of = WorkRows(of[0], of[1], of[2], of[3], of[4], masks[thread, 0, live], of[5])
            for each in range(tile + thread * (after - tile) // threads,
                              tile + (thread + 1) * (after - tile) // threads):  # fmt: skip
                g, area = tile_area(each, (n, rows, cols), height, wide)
                job = Job(code, number, steps, g, area.r0, area.r1, area.c0, area.c1)
                call(rule[1], (job, planes, rule, live_rows, rings[thread], rows_of, found[thread]))
        count, number = count - steps, number + 1


class TermTiles:
    """The terms of a table and the tiles of planes (n, layers, rows, cols) in which they are summed.

    ``gains`` of the layers, ``scheme`` and output characteristic ``f`` are for steps. ``work`` estimates the sums in
    one step. The constants are bare tuples in the order of their NamedTuple: numba takes 1.2 us for the class of each.
    """

    def __init__(
        self, plan: Plan, table: TermTable, shape: tuple[int, ...], dtype: np.dtype[Any],
        gains: Sequence[float] = (1.0,), scheme: Scheme | None = None, f: Function | None = None,
    ) -> None:  # fmt: skip
        n, layers, rows, cols = self.shape = shape
        work = int(np.prod(shape)) * max(1, len(table.taps.k))
        self.channels, self.work = table.channels, TERM * work
        self._step, self._loop, threads = plan.step, advance.for_work(work), threads_for(work)
        r, boundary = table.radius, plan.boundary
        torus, stages = boundary.kind == "periodic", 1 if scheme is None else len(scheme.b)
        low = rows if torus and max(rows, cols) <= LOW else 0
        down = 1 if low else max(-(-rows // HIGH), min(-(-threads // n), -(-rows // LEAST)))
        height, wide = -(-rows // down), -(-cols // -(-cols // WIDE))
        self.depth = 1 if scheme is None or plan.method == "general" else max(1, plan.depth)
        around = 0 if low else 2 * self.depth * stages * r
        self.count = n * -(-rows // height) * -(-cols // wide)
        self._tiles = threads, height, wide, wide + around if torus else min(cols, wide + around), self.depth
        self._seen = _channel_records(table, outputs=plan.cell != "discrete-time")
        kind, places, at, values, numbers = f or Function(0, 0, 0, 0, np.empty(0, dtype))
        numbers_of = numbers[at : at + places].copy(), numbers[values:].copy()
        self._compiled = functions(dtype), step_of(dtype)
        steps = (
            np.array(gains, dtype),
            plan.cell == "full-range",
            *_stages(scheme, dtype, plan.step if plan.method == "stepped" else None),
        )
        edge = r, int(boundary_code(boundary)), dtype.type(boundary.u), dtype.type(boundary.y), low
        rule = _rule(table, self._seen, steps, (int(kind), *numbers_of), edge)
        addresses: Any = (int(function.address) for function in self._compiled)
        self._rule = tuple(TermRule(*addresses, *rule))
        self._found = np.zeros((threads, layers + FOUND + APART), dtype)
        self.inputs = np.empty((0, *shape), dtype)

    def start_span(self, number: int, u: Any) -> None:
        """Use the inputs of step ``number`` from now on."""
        planes: list[Array] = []
        for m, channel in enumerate(self.channels):
            if channel.quantity == "u":
                plane = at_step(u, number - channel.ago, self._step)
                at = next((k for k, other in enumerate(planes) if other is plane), len(planes))
                planes += [plane] if at == len(planes) else []
                self._seen["plane"][m] = at
        if planes:  # inputs of several times are copied
            self.inputs = planes[0][None] if len(planes) == 1 else np.stack(planes)

    def do(self, task: TaskCode, planes: tuple[Array, Array, Array, Array], number: int, count: int) -> Array:
        """Do a task of `advance` in ``count`` steps from the state ``number``, with the planes start, states, w, mask.

        Return what the threads found: see `step_tile`. A pass that takes long is cut into pieces, so that Python can
        handle signals in between.
        """
        start, states, w, mask = planes
        whole, self._found[:] = (start, states, self.inputs, w, mask), 0
        given = whole, self._rule, self._tiles, self._found
        work = self.work * min(count, self.depth)
        if work <= PIECE:
            self._loop(*given, (int(task), number, count, 0, self.count))
        else:
            for done in range(0, count, self.depth):
                steps = min(self.depth, count - done)
                for tile, after in pieces(self.count, work / self.count, self._tiles[0]):
                    self._loop(*given, (int(task), number, steps, tile, after))
                number += 1
        found: Array = self._found.max(axis=0)[: self.shape[1] + FOUND]
        return found


def _rule(table: TermTable, channels: Array, steps: Any, f: Any, edge: Any) -> tuple[Any, ...]:
    """Return the fields of a `TermRule` after the addresses."""
    taps = records(**table.taps._asdict())
    return *steps, *f, channels, _term_records(table), taps, table.planes, table.numbers, *edge


def _channel_records(table: TermTable, *, outputs: bool) -> Array:
    """Return for each channel: which plane of the inputs it is of (NOTHING: it follows the state), its layer, how many
    steps ago, and whether it is the output of a state (``outputs``: the output differs from the state).
    """
    channels = table.channels
    return records(
        plane=np.full(len(channels), NOTHING, np.int64),
        layer=np.array([channel.layer for channel in channels], np.int64),
        ago=np.array([channel.ago for channel in channels], np.int64),
        output=np.array([channel.quantity == "y" and outputs for channel in channels], bool),
    )


def _term_records(table: TermTable) -> Array:
    """Return terms as records; ``linear``: a sum of neighbours weighted by numbers."""
    terms = table.terms
    plain = (terms.kind == FunctionCode.IDENTITY) & (terms.centre < 0) & (terms.times_neighbour < 0)
    local = [
        bool((table.taps.plane[first:end] >= 0).any())
        for first, end in zip(terms.first_tap, terms.end_tap, strict=True)
    ]
    return records(**terms._asdict(), linear=plain & ~np.array(local, bool))


def _stages(scheme: Scheme | None, dtype: np.dtype[Any], step: float | None) -> tuple[Array, Array, bool]:
    """Return the table of a scheme, times its gain of a ``step`` if given; how far its stages look ahead; and whether
    rates are kept. No scheme is one stage.
    """
    if scheme is None:
        return np.empty(0, dtype), np.zeros(1, np.int64), False
    h = 1.0 if step is None else scheme.gain(step)
    table = np.concatenate(((h * scheme.matrix).reshape(-1), h * np.array(scheme.b))).astype(dtype)
    return table, np.array([round(sum(row)) for row in scheme.a], np.int64), scheme.keeps_rates
