"""Steps of networks of terms, and of linear templates with stages, masks or limits: planes, spans and steppers.

The terms of the input alone are summed once for each span of time in which the input stays the same.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from cnnsim.backends.base import Check, Stepper
from cnnsim.backends.codes import TaskCode
from cnnsim.backends.cpu.tiles.term_tiles import TermTiles
from cnnsim.backends.term_table import TermTable, characteristic, longest_delay, table_of, tabulate
from cnnsim.network import Frames, Term
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Flags

STRIP = 1 << 14
"""Cells whose outputs are computed at a time, so that NumPy's temporary arrays stay in the cache."""
_TABLES: WeakKeyDictionary[Plan, dict[Any, tuple[TermTable, TermTable]]] = WeakKeyDictionary()


def _tables_of(plan: Plan, dtype: np.dtype[Any]) -> tuple[TermTable, TermTable]:
    """Return the tables of the terms of the input alone and of all others, made once for a plan."""
    tables = _TABLES.setdefault(plan, {})
    if dtype not in tables:
        if plan.network is None:
            feedback = [(0, Term(plan.template.A, "y_kl"))] if plan.template.feedback_taps else []
            tables[dtype] = tabulate(plan, [], dtype), tabulate(plan, feedback, dtype)
        else:
            tables[dtype] = table_of(plan, dtype, static=True), table_of(plan, dtype, static=False)
    return tables[dtype]


def _add_input_terms(tiles: TermTiles, w: Array) -> None:
    if tiles.channels:
        tiles.do(TaskCode.DRIVE, (w, w[None], w, _no_mask(w)), 0, 1)


def _no_mask(planes: Array) -> Array:
    """Return the words of a mask that holds no cell."""
    return np.empty((len(planes) * planes.shape[1], 0, 0), np.uint64)


def with_control_terms(plan: Plan, u: Array | None, bias: Array | None, total: Array) -> Array | None:
    """Return the bias map plus all terms of the input of a linear template, in ``total`` where there are any."""
    terms = plan.template.control_terms
    if u is None or not terms:
        return bias
    total[...] = 0 if bias is None else bias
    shape = (-1, 1, *u.shape[-2:])
    w = total.reshape(shape)
    tiles = TermTiles(plan, tabulate(plan, [(0, term) for term in terms], u.dtype), w.shape, u.dtype)
    tiles.start_span(0, u.reshape(shape))
    _add_input_terms(tiles, w)
    return total


class Network:
    """The states of a run in time order and the tiles that step them; of a linear template, whose w stays the same.

    ``mask`` is its words. `start` is the state of step 0, which stays as it is, `states` are those of later steps, as
    many as are read or written at once.
    """

    def __init__(self, plan: Plan, x: Array, w: Array | None, mask: Array | None) -> None:
        self.plan, layers = plan, 1 if plan.network is None else len(plan.network.layers)
        constants, scheme = (1.0,) if plan.network is None else plan.network.time_constants, plan.scheme
        self._end_shape = x.shape
        self.start = x.reshape(-1, layers, *plan.shape)
        self.mask = _no_mask(self.start) if mask is None else mask
        self.rates = 1 / np.array(constants)
        gains = [scheme.gain(plan.step * rate) if scheme else 1.0 for rate in self.rates]
        f, (_, moving) = characteristic(plan, x.dtype), _tables_of(plan, x.dtype)
        self._moving = TermTiles(plan, moving, self.start.shape, x.dtype, gains, scheme, f)
        self.work = self._moving.work
        delay = 0 if plan.network is None else longest_delay(plan, plan.network)
        self.states = np.empty((delay + 2, *self.start.shape), x.dtype)
        self._w = np.empty_like(self.start) if w is None else w.reshape(self.start.shape)

    def start_span(self, number: int) -> None:
        """Use input and bias of step ``number`` from now on."""

    def do(self, task: TaskCode, step: int, count: int) -> Array:
        """Do a task in ``count`` steps; return what `TermTiles.do` found."""
        return self._moving.do(task, (self.start, self.states, self._w, self.mask), step, count)

    def end(self, steps: int) -> Array:
        """Return the state after all steps in the shape of the given planes, and free the other planes."""
        end = self.states[steps % len(self.states)] if steps else self.start
        del self._w
        end = end.copy()
        self.states = self.states[:0]
        return end.reshape(self._end_shape)


class TermNetwork(Network):
    """A network of terms; ``u`` and ``bias`` may be `Frames`."""

    def __init__(self, plan: Plan, x: Array, u: Any, bias: Any, mask: Array | None) -> None:
        super().__init__(plan, x, None, mask)
        assert plan.network is not None
        self._network, shape = plan.network, self.start.shape
        self._u, self._bias = (_planes(value, shape) for value in (u, bias))
        self._z = np.array([layer.z for layer in plan.network.layers], x.dtype).reshape(-1, 1, 1)
        self._still = TermTiles(plan, _tables_of(plan, x.dtype)[0], shape, x.dtype)

    def spans(self) -> list[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stay the same."""
        plan = self.plan
        return list(spans(plan.steps, plan.step, delays_of(self._network), self._u, self._bias)) or [(0, 0)]

    def start_span(self, number: int) -> None:
        """Use input and bias of step ``number`` from now on."""
        self._w[:] = self._z
        if self._bias is not None:
            self._w += at_step(self._bias, number, self.plan.step)
        for tiles in (self._still, self._moving):
            tiles.start_span(number, self._u)
        _add_input_terms(self._still, self._w)


def _planes(value: Any, shape: tuple[int, ...]) -> Any:
    if value is None:
        return None
    return value.map(lambda plane: plane.reshape(shape)) if isinstance(value, Frames) else value.reshape(shape)


class TermSteps(Stepper):
    """Steps of dx/dt = (drive - x) / T; in the full-range model every stage ends within +-1."""

    def __init__(self, network: Network) -> None:
        assert network.plan.scheme is not None
        self._network, self._done = network, 0
        self.work = network.work * len(network.plan.scheme.b)
        self.start_span = network.start_span
        self._freezes = network.plan.method == "stepped" and network.plan.saturation_ends

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        *largest, _, unsaturated = self._network.do(TaskCode.CHECK, step, 1)
        rate = max(largest * self._network.rates.astype(self._network.start.dtype))
        return Check(float(rate), self._freezes and not unsaturated)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        self._network.do(TaskCode.STEP, step, count)
        self._done = step + count

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._network.end(self._done)


class DiscreteSteps(Stepper):
    """Steps of y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    def __init__(self, network: Network, mask: Flags | None) -> None:
        self._network, self.work, self._checked, self._done = network, network.work, False, 0
        self.start_span = network.start_span
        x, y = network.start, network.states[0]
        cols = x.shape[-1]
        lines, first, many = x.reshape(-1, cols), y.reshape(-1, cols), max(1, STRIP // cols)
        for i in range(0, len(lines), many):
            first[i : i + many] = network.plan.characteristic(lines[i : i + many])
        if mask is not None:
            np.copyto(first, lines, where=mask.reshape(first.shape))
        network.start = y

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `Stepper.check_settled`."""
        *largest, differs, _ = self._network.do(TaskCode.DISCRETE, step, 1)
        self._checked = True
        return Check(float(max(largest)), repeats=step > 0 and not differs)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        begin = step + self._checked  # the check has taken the first step already
        if begin < step + count:
            self._network.do(TaskCode.DISCRETE, begin, step + count - begin)
        self._checked, self._done = False, step + count

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._network.end(self._done)
