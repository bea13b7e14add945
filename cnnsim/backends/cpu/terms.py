"""Terms, layers, delays and sequences: the planes of a run, its channels, and what drives its layers.

What the input alone drives is added up once in each span of time in which the input stands still.
"""

from functools import partial
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from cnnsim.backends.cpu import term_loops as loops
from cnnsim.backends.cpu.boundary import virtual_cells
from cnnsim.backends.cpu.jit.columns import records
from cnnsim.backends.cpu.jit.compile import Kernel, threads_for
from cnnsim.backends.cpu.term_loops import DRIVE, NO_MASK
from cnnsim.backends.slices import PIECE, TERM, pieces
from cnnsim.backends.term_table import TermTable, characteristic, longest_delay, table_of, tabulate
from cnnsim.network import Frames
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.support import Array

_TABLES: WeakKeyDictionary[Plan, dict[Any, tuple[TermTable, TermTable]]] = WeakKeyDictionary()


def tables_of(plan: Plan, dtype: np.dtype[Any]) -> tuple[TermTable, TermTable]:
    """Return the tables of the terms that stand still and of those that move; made once for a plan."""
    tables = _TABLES.setdefault(plan, {})
    if dtype not in tables:
        tables[dtype] = table_of(plan, dtype, static=True), table_of(plan, dtype, static=False)
    return tables[dtype]


class Channels:
    """The channels of a table of terms with their virtual cells."""

    def __init__(self, plan: Plan, table: TermTable, grids: int, dtype: np.dtype[Any]) -> None:
        r, (rows, cols), boundary = table.radius, plan.shape, plan.boundary
        self.channels, self.work = table.channels, max(1, len(table.taps.k))
        self.padded = np.zeros((len(table.channels), grids, rows + 2 * r, cols + 2 * r), dtype)
        virtual = (
            virtual_cells(plan.shape, r, boundary, dtype.type(constant)) for constant in (boundary.u, boundary.y)
        )
        self.around_u, around_y = virtual
        terms, taps = records(table.terms), records(table.taps)
        self._group = (self.padded, terms, taps, table.planes, table.numbers), around_y

    def fill(self, channel: int, source: Array) -> None:
        """Bring a plane (n, rows, cols) of an input into a channel."""
        loops.fill_channel.for_work(source.size)(self.padded[channel], source, self.around_u)

    def loop(self, cells: Any, following: Array, f: Any, size: int) -> Kernel:
        """Return `term_loops.advance` for so many cells of the drives, but for its planes and job.

        A job of a step that takes long is done piece by piece, so that Python can hear a signal.
        """
        work = size * self.work
        run = *(function.address for function in loops.called(self.padded.dtype)), threads_for(work)
        whole = partial(loops.advance.for_work(work), run, cells, following, f, *self._group)

        def by_pieces(planes: Any, job: tuple[int, int, int, int, int]) -> None:
            task, first, count, _, lines = job
            for number in range(first, first + count):
                for row, after in pieces(lines, TERM * work / lines):
                    whole(planes, (task, number, 1, row, after))

        return whole if TERM * work <= PIECE else by_pieces

    def add_to(self, w: Array) -> None:
        """Add the terms of channels that stand still to w."""
        flat, none = w.reshape(-1), np.empty(0, np.int64)
        following = records(loops.Following(none, none, none, none > 0))
        advance = self.loop((flat, NO_MASK, False), following, (0, 0, 0, 0, flat), w.size)
        advance((w, flat, w, w, w[None]), (DRIVE, 0, 1, 0, w.size // w.shape[-1]))


def with_control_terms(plan: Plan, u: Array | None, bias: Array | None) -> Array | None:
    """Return the bias map plus all terms of the input alone: linear templates need no more."""
    terms = plan.template.control_terms
    if u is None or not terms:
        return bias
    rows, cols = u.shape[-2:]
    total = np.zeros(u.shape, u.dtype) if bias is None else bias.copy()
    table = tabulate(plan, [(0, term) for term in terms], u.dtype)
    field = Channels(plan, table, total.size // (rows * cols), u.dtype)
    field.fill(0, u.reshape(-1, rows, cols))
    field.add_to(total.reshape(-1, 1, rows, cols))
    return total


class CompiledNetwork:
    """The planes of a run, its past, and what drives each layer; ``u`` and ``bias`` may be `Frames`.

    ``advance`` is `term_loops.advance` but for its planes and job; a ``mask`` without cells holds none.
    """

    def __init__(self, plan: Plan, x: Array, u: Any, bias: Any, mask: Array) -> None:
        assert plan.network is not None
        self.plan, self.dtype, self._network = plan, x.dtype, plan.network
        layers, self._end_shape = plan.network.layers, x.shape
        self.shape = (x.size // (len(layers) * plan.shape[0] * plan.shape[1]), len(layers), *plan.shape)
        self.x = x.reshape(self.shape)
        self._u, self._bias = self._planes(u), self._planes(bias)
        self.mask = mask.reshape(self.shape) if mask.size else NO_MASK
        self._z = np.array([layer.z for layer in layers], x.dtype).reshape(-1, 1, 1)
        self._still, self._moving = (Channels(plan, t, self.shape[0], x.dtype) for t in tables_of(plan, x.dtype))
        follow = [(number, *c) for number, c in enumerate(self._moving.channels) if c.quantity != "u"]
        following = loops.Following(
            np.array([number for number, *_ in follow], np.int64),
            np.array([layer for _, _, layer, _ in follow], np.int64),
            np.array([ago for *_, ago in follow], np.int64),
            np.array([quantity == "y" and plan.cell != "discrete-time" for _, quantity, _, _ in follow], bool),
        )
        self.rates = 1 / np.array(plan.network.time_constants)
        gains = [plan.scheme.gain(plan.step * rate) if plan.scheme else 1.0 for rate in self.rates]
        self.cells = np.array(gains, x.dtype), self.mask, plan.cell == "full-range"
        delay = longest_delay(plan, plan.network)
        self.past = np.empty((delay + 1 if delay else 0, *self.shape), x.dtype)
        self.past[:] = self.x  # before t = 0 the state was x(0)
        self.w = np.empty_like(self.x)
        self.largest = np.empty(self.x.size // plan.shape[1], x.dtype)
        kind, *function = characteristic(plan, x.dtype)
        f = int(kind), *function  # numba asks for the class of an enum, which is slow
        self.advance = self._moving.loop(self.cells, records(following), f, self.x.size)
        self.lines, self.work = self.x.size // plan.shape[1], TERM * self.x.size * self._moving.work

    def _planes(self, value: Any) -> Any:
        if value is None:
            return None
        return value.map(self._planes) if isinstance(value, Frames) else value.reshape(self.shape)

    def spans(self) -> list[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stand still."""
        plan = self.plan
        return list(spans(plan.steps, plan.step, delays_of(self._network), self._u, self._bias)) or [(0, 0)]

    def keep(self, number: int, x: Array) -> None:
        """Keep the state at the beginning of a step, if a term will ask for it."""
        if len(self.past):
            self.past[number % len(self.past)] = x

    def start_span(self, number: int) -> None:
        """Take input and bias as they are from step ``number`` on."""
        step = self.plan.step
        self.w[:] = self._z
        if self._bias is not None:
            self.w += at_step(self._bias, number, step)
        for field in (self._still, self._moving):
            for k, channel in enumerate(field.channels):
                if channel.quantity == "u":
                    field.fill(k, at_step(self._u, number - channel.ago, step)[:, channel.layer])
        self._still.add_to(self.w)

    def end(self, x: Array) -> Array:
        """Return a state in the shape in which planes were given."""
        return x.reshape(self._end_shape)
