"""Transients whose derivatives can be pulled back: planes, spans, and states that are kept or computed again."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise
from math import isqrt
from typing import Any

import numpy as np

from cnnsim.backends.codes import FunctionCode
from cnnsim.backends.cpu.compiled import records, threads_for
from cnnsim.backends.slices import PIECE
from cnnsim.backends.term_table import characteristic, tabulate
from cnnsim.learning.adjoint_loops import backward, forward
from cnnsim.learning.adjoint_terms import INPUT, OUTPUT, STATE, Rule
from cnnsim.network import AnyTemplate, LayeredTemplate, Template, Term, layered
from cnnsim.network.boundary import virtual_index
from cnnsim.network.frames import at_step, spans
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import EULER
from cnnsim.support import Array, Floats, InputError
from cnnsim.task import Task

KEPT_BYTES = 1 << 28
"""Bytes of states that are kept; a longer transient keeps each sqrt(steps)-th state and computes the others again."""
_QUANTITIES = {"x": STATE, "y": OUTPUT, "u": INPUT}


def terms_of(network: LayeredTemplate, *, static: bool) -> list[tuple[int, Term]]:
    """Return (layer, term) of the terms of the input alone (``static``), or of all others; B and A come first."""
    if static:
        return [(n, term) for n, own in enumerate(network.layers) for term in (Term(own.B, "u_kl"), *own.control_terms)]
    return [(n, term) for n, own in enumerate(network.layers) for term in (Term(own.A, "y_kl"), *own.feedback_terms)]


def weights_of(network: LayeredTemplate) -> Floats:
    """Return the weights of all terms of the input, then of all others, in the order of `terms_of`, zeros too."""
    return np.concatenate([term.weights.ravel() for s in (True, False) for _, term in terms_of(network, static=s)])


def with_weights(template: AnyTemplate, weights: Floats, z: Floats) -> AnyTemplate:
    """Return a template with other weights, the reverse of `weights_of`, and with z (layers,)."""
    network = layered(template)
    shapes = [term.weights.shape for s in (True, False) for _, term in terms_of(network, static=s)]
    ends = np.cumsum([np.prod(shape) for shape in shapes])[:-1]
    parts = iter([part.reshape(shape) for part, shape in zip(np.split(weights, ends), shapes, strict=True)])
    by_input = [[next(parts) for _ in (own.B, *own.control_terms)] for own in network.layers]
    others = [[next(parts) for _ in (own.A, *own.feedback_terms)] for own in network.layers]
    layers = []
    for own, (b, *control), (a, *feedback), bias in zip(network.layers, by_input, others, z, strict=True):
        new = dict(zip(map(id, (*own.control_terms, *own.feedback_terms)), (*control, *feedback), strict=True))
        layers.append(Template(a, b, bias, own.name, [replace(term, weights=new[id(term)]) for term in own.terms]))
    if isinstance(template, LayeredTemplate):
        return LayeredTemplate(layers, template.time_constants, template.name)
    return layers[0]


@dataclass(frozen=True, eq=False)
class Pulled:
    """Derivatives of a loss by the weights (in the order of `weights_of`), by z (layers,), and by the planes of a run.

    ``input`` and ``bias`` have a plane (n, layers, rows, cols) for each span of constant inputs.
    """

    weights: Floats
    z: Floats
    state: Array
    input: list[Array]
    bias: list[Array]


class AdjointTransient:
    """A transient on the cpu in ``dtype`` for any weights, and the derivatives of losses on its states.

    ``steps`` of the plan's scheme are taken. The states of ``forward`` are kept until the next one.

    Raises:
        InputError: the states have no derivative by the weights: discrete time, sign, delays, weights by cell.
    """

    def __init__(self, task: Task, steps: int, dtype: Any = np.float64) -> None:
        plan, self.dtype, self.steps = task.plan, np.dtype(dtype), steps
        self.network = plan.network or layered(plan.template)
        _check_differentiable(plan, self.network)
        self._rules = [_rule(task, self.network, self.dtype, static=s) for s in (True, False)]
        self._shape = (-1, len(self.network.layers), *plan.shape)
        self.state = self._load(task.state)
        self._ones = np.ones_like(self.state)
        self._free = self._ones if task.mask is None else self._load(~task.mask)
        self.starts = [first for first, _ in spans(max(1, steps), plan.step, [], task.input, task.bias)]
        self.inputs, self._biases = (
            [
                self._load(0.0 * task.state if value is None else at_step(value, first, plan.step))
                for first in self.starts
            ]
            for value in (task.input, task.bias)
        )
        self._kept: dict[int, Array] = {}
        self._spare: dict[tuple[int, ...], Array] = {}
        self._drives: list[Array] = []
        self._weights: tuple[Array, Array] = (np.empty(0), np.empty(0))

    def _load(self, plane: Array) -> Array:
        return np.ascontiguousarray(plane, self.dtype).reshape(self._shape)

    def forward(self, weights: Floats, z: Floats, at: tuple[int, ...] = ()) -> dict[int, Array]:
        """Run from ``state`` and return the states (n, layers, rows, cols) after the numbers of steps ``at``.

        Arguments: ``weights`` in the order of `weights_of`; ``z`` (layers,).
        """
        cut = len(self._rules[0].taps)
        self._weights = weights[:cut].astype(self.dtype), weights[cut:].astype(self.dtype)
        offset = z.astype(self.dtype)[:, None, None]
        self._drives = []
        for u, bias in zip(self.inputs, self._biases, strict=True):
            path = self._path(0.0 * u, (bias + offset, u, self._ones, self._weights[0], self._rules[0]), 1)
            self._drives.append(np.ascontiguousarray(path[:, 1]))
        self._spare |= {path.shape: path for path in self._kept.values() if self._whole}
        self._kept, self._cuts = {}, self._edges(at)
        x, found = self.state, {0: self.state}
        for first, end in pairwise(self._cuts):
            path = self._path(x, self._given(first), end - first, whole=self._whole)
            self._kept[first] = path if self._whole else x
            found[end] = x = path[:, (end - first) % path.shape[1]].copy()
        return {step: found[step] for step in at}

    @property
    def _whole(self) -> bool:
        return self.steps * self.state.nbytes <= KEPT_BYTES

    def _edges(self, at: tuple[int, ...]) -> list[int]:
        """Return the steps between which the compiled loops run: spans, losses, kept states, room for Ctrl-C."""
        work = self.state.size * len(self._rules[1].taps)
        every = max(1, min(self.steps if self._whole else isqrt(self.steps), PIECE // work))
        return sorted({*self.starts, *at, *range(0, self.steps, every), self.steps})

    def _path(self, x: Array, given: tuple[Any, ...], steps: int, *, whole: bool = True) -> Array:
        """Return the states of a run from x, or (not ``whole``) the last two, state s at s % 2."""
        shape = len(x), steps + 1 if whole else 2, *x.shape[1:]
        path = self._spare.pop(shape, None)  # the pages of new memory would take as long as the run
        path = np.empty(shape, self.dtype) if path is None else path
        path[:, 0] = x
        _on_threads(forward, path, given, steps)
        return path

    def _span(self, step: int) -> int:
        return sum(start <= step for start in self.starts) - 1

    def _given(self, step: int) -> tuple[Any, ...]:
        span = self._span(step)
        return self._drives[span], self.inputs[span], self._free, self._weights[1], self._rules[1]

    def backward(self, bars: Mapping[int, Array]) -> Pulled:
        """Return the derivatives of a loss of the last run; ``bars[s]`` is its derivative by the state after step s."""
        n, zeros = len(self.state), np.zeros_like
        of_x, of_w, of_u = zeros(self.state), [zeros(u) for u in self.inputs], [zeros(u) for u in self.inputs]
        of_static, of_moving = (np.zeros((n, len(rule.taps))) for rule in self._rules)
        for first, end in reversed(list(pairwise(self._cuts))):
            if end in bars:
                of_x += bars[end]
            kept, span = self._kept[first], self._span(first)
            path = kept if self._whole else self._path(kept, self._given(first), end - first)
            _on_threads(backward, path, self._given(first), end - first, of_x, of_w[span], of_u[span], of_moving)
        if 0 in bars:
            of_x += bars[0]
        for u, from_w, from_u in zip(self.inputs, of_w, of_u, strict=True):
            path, given = (
                np.zeros((n, 2, *u.shape[1:]), self.dtype),
                (u, u, self._ones, self._weights[0], self._rules[0]),
            )
            _on_threads(backward, path, given, 1, from_w.copy(), zeros(u), from_u, of_static)
        weights = np.concatenate([of_static.sum(axis=0), of_moving.sum(axis=0)])
        z = np.sum([plane.sum(axis=(0, 2, 3), dtype=np.float64) for plane in of_w], axis=0)
        return Pulled(weights, z, of_x, of_u, of_w)


def _on_threads(loop: Any, path: Array, given: tuple[Any, ...], steps: int, *bars: Array) -> None:
    """Run a loop on the grids of a batch, divided among threads; the loops release Python's lock."""
    w, u, free, weights, rule = given
    count = min(len(path), threads_for(path[:, 0].size * steps * len(weights)))
    parts = [slice(len(path) * k // count, len(path) * (k + 1) // count) for k in range(count)]

    def run(part: slice) -> None:
        into = (tuple(bar[part] for bar in bars),) if bars else ()
        loop(path[part], w[part], u[part], free[part], weights, rule, steps, *into)

    if count == 1:
        run(parts[0])
        return
    with ThreadPoolExecutor(count) as crew:
        list(crew.map(run, parts))


def _check_differentiable(plan: Plan, network: LayeredTemplate) -> None:
    terms = [term for layer in network.layers for term in layer.terms]
    why = (
        "discrete time" if plan.cell == "discrete-time"
        else "the output sign" if plan.characteristic.kind == "sign"
        else "a delay" if any(term.delay for term in terms)
        else "weights by cell" if any(term.weights.ndim == 4 for term in terms)
        else "no fixed step" if plan.scheme is None
        else ""
    )  # fmt: skip
    if why:
        wanted = "cells in continuous time with a clip, tanh or table, terms without delay, a scheme with steps wanted"
        raise InputError(f"gradient of template {plan.template.name!r} with {why}; {wanted}")


def _rule(task: Task, network: LayeredTemplate, dtype: np.dtype[Any], *, static: bool) -> Rule:
    """Return the rule of the steps, or (``static``) that of one Euler step from 0, which gives w = B*u + z + bias."""
    plan, boundary = task.plan, task.plan.boundary
    ones = [(n, replace(term, weights=np.ones_like(term.weights))) for n, term in terms_of(network, static=static)]
    table, f = tabulate(plan, ones, dtype), characteristic(plan, dtype)
    scheme = EULER if static or plan.scheme is None else plan.scheme
    gains = [1.0 if static else scheme.gain(plan.step / time) for time in network.time_constants]
    places = f.places if f.kind in (FunctionCode.LINEAR, FunctionCode.STEP) else 1
    of_input = 0.0 if task.input is None else boundary.u
    rows, cols = (virtual_index(cells, table.radius, boundary) for cells in plan.shape)
    return Rule(
        np.array([(_QUANTITIES[one.quantity], one.layer) for one in table.channels], np.int64),
        records(**table.terms._asdict()), records(k=table.taps.k, l=table.taps.l),
        np.append(table.numbers, dtype.type(0)),  # never empty
        (rows, cols), (dtype.type(boundary.y), dtype.type(of_input)),
        (int(f.kind), f.numbers[f.at : f.at + places].copy(), np.append(f.numbers[f.values :], dtype.type(0))),
        (scheme.matrix.astype(dtype), np.array(scheme.b, dtype), np.array(gains, dtype)),
        plan.cell == "full-range" and not static,
    )  # fmt: skip
