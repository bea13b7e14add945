"""Steps of networks of terms, and of linear templates with stages, masks or limits: planes, spans and steppers.

The terms of the input alone are summed once for each span of time in which the input stays the same.
"""

from typing import Any
from weakref import WeakKeyDictionary

import numba
import numpy as np

from cnnsim.backends.base import Check, CheckedStepper
from cnnsim.backends.codes import TaskCode
from cnnsim.backends.cpu.tiles.term_tiles import TermTiles
from cnnsim.backends.term_table import characteristic, longest_delay, table_of, tabulate
from cnnsim.network import Frames, Term
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Flags

STRIP = 1 << 14
"""Cells whose outputs are computed at a time, so that NumPy's temporary arrays stay in the cache."""
_TILES: WeakKeyDictionary[Plan, dict[Any, tuple[TermTiles, TermTiles]]] = WeakKeyDictionary()


def _tiles_of(plan: Plan, dtype: np.dtype[Any], shape: tuple[int, ...]) -> tuple[TermTiles, TermTiles]:
    """Return the tiles of the terms of the input alone and of all others, made once for a plan and a shape."""
    tiles, key = _TILES.setdefault(plan, {}), (dtype, shape, numba.get_num_threads())
    if key not in tiles:
        network, scheme, f = plan.network, plan.scheme, characteristic(plan, dtype)
        if network is None:
            feedback = [(0, Term(plan.template.A, "y_kl"))] if plan.template.feedback_taps else []
            tables = tabulate(plan, [], dtype), tabulate(plan, feedback, dtype)
        else:
            tables = table_of(plan, dtype, static=True), table_of(plan, dtype, static=False)
        constants = (1.0,) if network is None else network.time_constants
        gains = [scheme.gain(plan.step * (1 / constant)) if scheme else 1.0 for constant in constants]
        if network is None:  # the table of the scheme has the length of a step, as in the reference
            gains = [0.0]
        still = TermTiles(plan, tables[0], shape, dtype)
        tiles[key] = still, TermTiles(plan, tables[1], shape, dtype, gains, scheme, f)
    return tiles[key]


def _add_input_terms(tiles: TermTiles, w: Array) -> None:
    if tiles.channels:
        tiles.do(TaskCode.DRIVE, (w, w[None], w, _no_mask(w)), 0, 1)


def _no_mask(planes: Array) -> Array:
    """Return the mask that holds no cell."""
    return np.empty((*planes.shape[:2], 0, 0), bool)


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

    `start` is the first state, which stays as it is, `states` are the later ones, as many as are read or written at
    once: one after each step, of a linear template one after each pass of several steps.
    """

    def __init__(self, plan: Plan, x: Array, w: Array | None, mask: Array | None) -> None:
        self.plan, layers = plan, 1 if plan.network is None else len(plan.network.layers)
        constants = (1.0,) if plan.network is None else plan.network.time_constants
        self._end_shape = x.shape
        self.start = x.reshape(-1, layers, *plan.shape)
        self.mask = _no_mask(self.start) if mask is None else mask.reshape(self.start.shape)
        self.rates = (1 / np.array(constants)).astype(x.dtype)
        self._still, self._moving = _tiles_of(plan, x.dtype, self.start.shape)
        self.work, self.depth, self._number = self._moving.work, self._moving.depth, 0
        delay = 0 if plan.network is None else longest_delay(plan, plan.network)
        self.states = np.empty((delay + 2, *self.start.shape), x.dtype)
        self._w = np.empty_like(self.start) if w is None else w.reshape(self.start.shape)

    def start_span(self, number: int) -> None:
        """Use input and bias of step ``number`` from now on."""

    def do(self, task: TaskCode, count: int = 1) -> Array:
        """Do a task from the present state on; return what `TermTiles.do` found."""
        found = self._moving.do(task, (self.start, self.states, self._w, self.mask), self._number, count)
        if task in (TaskCode.STEP, TaskCode.DISCRETE):
            self._number += -(-count // self.depth)
        return found

    def end(self, back: int = 0) -> Array:
        """Return the present state, or one before it, in the memory of w, and free the other planes."""
        number = self._number - back
        end = self._w
        end[:] = self.states[number % len(self.states)] if number else self.start
        del self._w
        self._still.inputs = self._moving.inputs = self._moving.inputs[:0]
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

    def spans(self) -> list[tuple[int, int]]:
        """Return (first step, steps) of the spans in which input and bias stay the same."""
        plan = self.plan
        return list(spans(plan.steps, plan.step, delays_of(self._network), self._u, self._bias))

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


class _NetworkSteps(CheckedStepper):
    """Steps of a network."""

    def __init__(self, network: Network) -> None:
        self._network, self.together, self.work = network, network.depth, network.work

    def start_span(self, step: int) -> None:
        """See `CheckedStepper.start_span`."""
        self._network.start_span(step)


class TermSteps(_NetworkSteps):
    """Steps of dx/dt = (drive - x) / T; in the full-range model every stage ends within +-1."""

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        assert network.plan.scheme is not None
        self.work *= len(network.plan.scheme.b)
        self._freezes = network.plan.method == "stepped" and network.plan.saturation_ends

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedStepper.check_settled`."""
        *largest, _, unsaturated = self._network.do(TaskCode.CHECK)
        return Check(float(max(largest * self._network.rates)), self._freezes and not unsaturated)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        self._network.do(TaskCode.STEP, count)

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._network.end()


class DiscreteSteps(_NetworkSteps):
    """Steps of y(k + 1) = f(drive); where f is the sign, a drive of 0 keeps the output."""

    def __init__(self, network: Network, mask: Flags | None) -> None:
        super().__init__(network)
        self._checked = False
        x, y = network.start, network.states[0]
        cols = x.shape[-1]
        lines, first, many = x.reshape(-1, cols), y.reshape(-1, cols), max(1, STRIP // cols)
        for i in range(0, len(lines), many):
            first[i : i + many] = network.plan.characteristic(lines[i : i + many])
        if mask is not None:
            np.copyto(first, lines, where=mask.reshape(first.shape))
        network.start = y

    def check_settled(self, step: int, *, last: bool) -> Check:
        """See `CheckedStepper.check_settled`."""
        *largest, differs, _ = self._network.do(TaskCode.DISCRETE)
        self._checked = True
        return Check(float(max(largest)), repeats=step > 0 and not differs)

    def advance(self, step: int, count: int) -> None:
        """See `Stepper.advance`."""
        if count > self._checked:  # the check has taken the first step already
            self._network.do(TaskCode.DISCRETE, count - self._checked)
        self._checked = False

    def finish(self) -> Array:
        """See `Stepper.finish`."""
        return self._network.end(int(self._checked))
