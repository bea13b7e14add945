"""Tiles in which the terms of a table are added up, prepared: tables, channels and stages as loops take them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cnnsim.backends.codes import NOTHING, TaskCode, boundary_code
from cnnsim.backends.cpu.jit.columns import records
from cnnsim.backends.cpu.jit.compile import threads_for
from cnnsim.backends.cpu.terms import loops
from cnnsim.backends.cpu.terms.groups import ChannelColumns, StageTable, Surround, TermArrays
from cnnsim.backends.slices import PIECE, TERM, pieces
from cnnsim.backends.term_table import Channel, Function, TermTable
from cnnsim.network.frames import at_step
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import Scheme
from cnnsim.support import Array

WIDE, HIGH = 1024, 512
"""The most columns and rows of a tile."""
LEAST = 8
"""The fewest rows of a tile: of lower ones a thread more would load as many around them."""
LOW = 32
"""Rows and columns of a torus up to which all its rows stay in the cache: around it would lie more cells than in it."""


class TermTiles:
    """The terms of a ``table`` and the tiles of planes (n, layers, rows, cols) in which they are added up.

    ``gains`` of the layers, ``scheme`` and output characteristic ``f`` are for tasks that make steps. ``work`` is a
    guess at the sums in one step.
    """

    def __init__(
        self, plan: Plan, table: TermTable, shape: tuple[int, ...], dtype: np.dtype[Any],
        gains: Sequence[float] = (1.0,), scheme: Scheme | None = None, f: Function | None = None,
    ) -> None:  # fmt: skip
        n, layers, rows, cols = shape
        work = int(np.prod(shape)) * max(1, len(table.taps.k))
        self.channels, self.work = table.channels, TERM * work
        self._step, self._loop, threads = plan.step, loops.advance.for_work(work), threads_for(work)
        r, boundary = table.radius, plan.boundary
        torus, stages = boundary.kind == "periodic", 1 if scheme is None else len(scheme.b)
        low = rows if torus and max(rows, cols) <= LOW else 0
        down = 1 if low else max(-(-rows // HIGH), min(-(-threads // n), -(-rows // LEAST)))
        height, wide = -(-rows // down), -(-cols // -(-cols // WIDE))
        around = 0 if low else 2 * stages * r
        width = wide + around if torus else min(cols, wide + around)
        self.count = n * -(-rows // height) * -(-cols // wide)
        self._run = *(function.address for function in loops.called(dtype)), threads, height, wide, width, low
        self._how = np.array(gains, dtype), plan.cell == "full-range"
        self._stages = tuple(stage_table(scheme, dtype))
        kind, *function = f or (0, 0, 0, 0, np.empty(0, dtype))
        self._f = int(kind), *function  # numba asks for the class of an enum, which is slow
        seen = columns(table.channels, outputs=plan.cell != "discrete-time")
        self._seen, terms, taps = records(seen), records(table.terms), records(table.taps)
        self._field = tuple(TermArrays(self._seen, terms, taps, table.planes.reshape(-1), table.numbers))
        constants = dtype.type(boundary.u), dtype.type(boundary.y)
        self._edge = tuple(Surround(r, int(boundary_code(boundary)), *constants))
        self.found = np.zeros((threads, layers + loops.APART), dtype)
        self.inputs = np.empty((0, n, layers, rows, cols), dtype)

    def start_span(self, number: int, u: Any) -> None:
        """Take the inputs that channels are of as they are from step ``number`` on."""
        planes: list[Array] = []
        for m, channel in enumerate(self.channels):
            if channel.quantity == "u":
                plane = at_step(u, number - channel.ago, self._step)
                at = next((k for k, other in enumerate(planes) if other is plane), len(planes))
                planes += [plane] if at == len(planes) else []
                self._seen["plane"][m] = at
        if planes:  # of different frames at once there are copies
            self.inputs = planes[0][None] if len(planes) == 1 else np.stack(planes)

    def do(self, task: TaskCode, planes: tuple[Array, Array, Array, Array], first: int, count: int) -> None:
        """Do a task of `loops.advance` in so many steps, with the planes start, states, w and mask.

        A step that takes long is done piece by piece, so that Python can hear a signal.
        """
        start, states, w, mask = planes
        given = self._run, self._how, self._stages, self._f, self._field, self._edge
        whole = start, states, self.inputs, w, mask
        if self.work <= PIECE:
            self._loop(*given, whole, self.found, (int(task), first, count, 0, self.count))
            return
        for number in range(first, first + count):
            for tile, after in pieces(self.count, self.work / self.count, self._run[2]):
                self._loop(*given, whole, self.found, (int(task), number, 1, tile, after))


def columns(channels: Sequence[Channel], *, outputs: bool) -> ChannelColumns:
    """Return channels as columns; ``outputs``: the output is another thing than the state."""
    return ChannelColumns(
        np.full(len(channels), NOTHING, np.int64),
        np.array([channel.layer for channel in channels], np.int64),
        np.array([channel.ago for channel in channels], np.int64),
        np.array([channel.quantity == "y" and outputs for channel in channels], bool),
    )


def stage_table(scheme: Scheme | None, dtype: np.dtype[Any]) -> StageTable:
    """Return a scheme as numbers; of none one stage of which nobody asks."""
    if scheme is None:
        return StageTable(np.empty(0, dtype), np.zeros(1, np.int64), keeps=False)
    numbers = np.concatenate((scheme.matrix.reshape(-1), scheme.b)).astype(dtype)
    return StageTable(numbers, np.array([round(sum(row)) for row in scheme.a], np.int64), scheme.keeps_rates)
