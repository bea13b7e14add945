"""Terms, layers, delays and sequences: the planes of a run, and what drives its layers.

What the input alone drives is added up once in each span of time in which the input stands still.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from cnnsim.backends.codes import TaskCode
from cnnsim.backends.cpu.terms.tiles import TermTiles
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


def add_still(tiles: TermTiles, w: Array) -> None:
    """Add the terms of inputs alone to w."""
    if tiles.channels:
        tiles.do(TaskCode.DRIVE, (w, w[None], w, no_mask(w)), 0, 1)


def no_mask(planes: Array) -> Array:
    """Return the words of the mask that holds no cell."""
    return np.empty((len(planes) * planes.shape[1], 0, 0), np.uint64)


def with_control_terms(plan: Plan, u: Array | None, bias: Array | None, total: Array) -> Array | None:
    """Return the bias map plus all terms of the input alone, in ``total``: linear templates need no more."""
    terms = plan.template.control_terms
    if u is None or not terms:
        return bias
    total[...] = 0 if bias is None else bias
    shape = (-1, 1, *u.shape[-2:])
    w = total.reshape(shape)
    tiles = TermTiles(plan, tabulate(plan, [(0, term) for term in terms], u.dtype), w.shape, u.dtype)
    tiles.start_span(0, u.reshape(shape))
    add_still(tiles, w)
    return total


class CompiledNetwork:
    """The planes of a run, its past, and what drives each layer; ``u`` and ``bias`` may be `Frames`.

    ``mask`` is its words, without words none. `start` is the state of step 0, which stays as it is, `states` are those
    of later steps, as many as are looked at or written at once.
    """

    def __init__(self, plan: Plan, x: Array, u: Any, bias: Any, mask: Array | None) -> None:
        assert plan.network is not None
        self.plan, self._network, layers = plan, plan.network, plan.network.layers
        self._end_shape, shape = x.shape, (-1, len(layers), *plan.shape)
        self.start = x.reshape(shape)
        self._u, self._bias = (self._planes(value, shape) for value in (u, bias))
        self.mask = no_mask(self.start) if mask is None else mask
        self._z = np.array([layer.z for layer in layers], x.dtype).reshape(-1, 1, 1)
        self.rates, scheme = 1 / np.array(plan.network.time_constants), plan.scheme
        gains = [scheme.gain(plan.step * rate) if scheme else 1.0 for rate in self.rates]
        still, moving = tables_of(plan, x.dtype)
        self._still = TermTiles(plan, still, self.start.shape, x.dtype)
        self._moving = TermTiles(plan, moving, self.start.shape, x.dtype, gains, scheme, characteristic(plan, x.dtype))
        self.work = self._moving.work
        self.states = np.empty((longest_delay(plan, plan.network) + 2, *self.start.shape), x.dtype)
        self._w = np.empty_like(self.start)

    @staticmethod
    def _planes(value: Any, shape: tuple[int, ...]) -> Any:
        if value is None:
            return None
        return value.map(lambda plane: plane.reshape(shape)) if isinstance(value, Frames) else value.reshape(shape)

    def spans(self) -> list[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stand still."""
        plan = self.plan
        return list(spans(plan.steps, plan.step, delays_of(self._network), self._u, self._bias)) or [(0, 0)]

    def start_span(self, number: int) -> None:
        """Take input and bias as they are from step ``number`` on."""
        self._w[:] = self._z
        if self._bias is not None:
            self._w += at_step(self._bias, number, self.plan.step)
        for tiles in (self._still, self._moving):
            tiles.start_span(number, self._u)
        add_still(self._still, self._w)

    def do(self, task: TaskCode, step: int, count: int) -> Array:
        """Do a task in so many steps; return the largest rate or change of each layer, and whether a row differs."""
        found = self._moving.found
        found[:] = 0
        self._moving.do(task, (self.start, self.states, self._w, self.mask), step, count)
        largest: Array = found.max(axis=0)
        return largest[: self.start.shape[1] + 1]

    def end(self, steps: int) -> Array:
        """Return the state after all steps, in the shape in which planes were given; the other planes go."""
        end = self.states[steps % len(self.states)] if steps else self.start
        del self._w
        end = end.copy()
        self.states = self.states[:0]
        return end.reshape(self._end_shape)
