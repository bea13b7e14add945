"""Blocks of a ``.tem`` file from a template of the library: the reverse of `terms`, as far as the format allows."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from itertools import product
from typing import Literal

import numpy as np

from cnnsim.formats.candy.content import Block, Call, FunctionLine, Layer, MatrixEntry, Operation, Section
from cnnsim.network import AnyTemplate, Argument, Table, Template, Term, layered
from cnnsim.support import Floats, InputError

_KINDS: dict[str, Operation] = {"y": "nonlin_feedback", "u": "nonlin_control"}


@dataclass
class _Matrix:
    """A non-linear block in the making: the entries by place."""

    side: int
    entries: dict[tuple[int, int], MatrixEntry] = field(default_factory=dict)

    def rows(self) -> tuple[tuple[MatrixEntry, ...], ...]:
        span = range(-(self.side // 2), self.side // 2 + 1)
        return tuple(tuple(self.entries.get((k, l), 0.0) for l in span) for k in span)


_WRITTEN = {"weights", "of", "table", "times", "delay", "layer"}
"""The fields of a term that are written; a term with any other field is refused."""


def template_section(template: AnyTemplate) -> Section:
    """Return the section of a template.

    Raises:
        InputError: what the format has no words for: time constants, weights that differ from cell to cell, delayed
            functions, a step whose edges would come to lie on the other side.
    """
    whole = layered(template)
    if set(whole.time_constants) != {1.0}:
        raise InputError(f"time constants {whole.time_constants}: a .tem file has none")
    several = len(whole.layers) > 1
    return Section(tuple(_layer(layer, number, several) for number, layer in enumerate(whole.layers, start=1)))


def _layer(template: Template, number: int, several: bool) -> Layer:
    own = number if several else None
    blocks = [*_linear("feedback", template.A, own), *_linear("control", template.B, own)]
    functions: list[FunctionLine] = []
    matrices: dict[tuple[Operation, int | None, str, str], _Matrix] = {}
    if unwritten := {part.name for part in fields(Term)} - _WRITTEN:
        raise InputError(f"terms have {', '.join(sorted(unwritten))}, which is not written here")
    for term in template.terms:
        if term.weights.ndim != 2:
            raise InputError("weights that differ from cell to cell: a .tem file has none")
        source = own if term.layer is None else term.layer + 1
        if term.table is None:
            blocks += _linear(_linear_kind(term), term.weights, source, term.delay or None)
            continue
        if term.delay:
            raise InputError(f"a delayed function, {term}: a .tem file has no block for it")
        operation, of, argument, factor, table = _nonlinear_kind(term, term.table)
        key = (operation, source, argument, factor)
        matrix = matrices.setdefault(key, _Matrix(max(term.weights.shape[0], 3)))
        matrix.side = max(matrix.side, term.weights.shape[0])
        sign = -1.0 if factor else 1.0  # the factor is turned as well, and its sign goes to the weights
        for k, l, weight in term.taps:
            if (k, l) in matrix.entries:
                raise InputError(f"two functions at ({k:+d}, {l:+d}): a .tem file has one entry there")
            matrix.entries[k, l] = Call(_letter(_scaled(table, sign * weight), functions), of)
    for (operation, source, argument, factor), matrix in matrices.items():
        blocks.append(Block(operation, matrix.rows(), source, matrix.side // 2, argument, factor))
    keys = [(block.operation, block.source, block.delay) for block in blocks]
    if double := next((key for key in keys if keys.count(key) > 1), None):
        raise InputError(f"{double[0].upper()} twice in layer {number}: readers of .tem files do not agree on that")
    return Layer(number, tuple(blocks), tuple(functions), template.z)


def _linear(kind: Operation, weights: Floats, source: int | None, delay: float | None = None) -> list[Block]:
    if not weights.any():
        return []
    full = np.pad(weights, 1) if weights.shape[0] == 1 else weights
    return [Block(kind, tuple(map(tuple, full.tolist())), source, full.shape[0] // 2, delay=delay)]


def _linear_kind(term: Term) -> Operation:
    if term.times is None and term.of.centre is None and term.of.neighbour in _KINDS:
        kind: Operation = "feedback" if term.of.neighbour == "y" else "control"
        return f"delayed_{kind}" if term.delay else kind  # type: ignore[return-value]  # both are operations
    raise InputError(f"the term {term}: a .tem file has no block for it")


def _nonlinear_kind(term: Term, table: Table) -> tuple[Operation, Literal["-", "0", ""], str, str, Table]:
    """Return operation, suffix, argument, factor and table as CANDY has them: centre minus neighbour."""
    of, times = term.of, term.times
    if times is None and of.centre is None and of.neighbour in _KINDS:
        return _KINDS[of.neighbour], "0", "", "", _edges_right(table, term)
    if of.centre is None or (times is not None and times.centre is None):
        raise InputError(f"the term {term}: a .tem file has no block for it")
    turned = _edges_right(table.mirrored(), term)
    if times is None and of.centre == of.neighbour and of.neighbour in _KINDS:
        return _KINDS[of.neighbour], "-", "", "", turned
    return "nonlin_d", "", _words(of), "" if times is None else _words(times), turned


def _words(argument: Argument) -> str:
    return f"{argument.centre}-{argument.neighbour}"


def _edges_right(table: Table, term: Term) -> Table:
    if table.kind == "step" and table.closed == "left" and table.at:
        raise InputError(f"the steps of {term} would change their values at the edges in a .tem file")
    return table


def _scaled(table: Table, weight: float) -> Table:
    return Table(table.kind, table.at, tuple(weight * value for value in table.values), table.closed)


def _letter(table: Table, functions: list[FunctionLine]) -> str:
    """Return the letter of a function, a new one if it is not there yet."""
    last = (table.at[-1] + 1 if table.at else 1.0,) if table.kind == "step" else ()
    points = tuple(zip((*table.at, *last), table.values, strict=True))
    for function in functions:
        if (function.linear, function.points) == (table.kind == "linear", points):
            return function.letter
    name = next(name for name in _names() if all(function.letter != name for function in functions))
    functions.append(FunctionLine(name, table.kind == "linear", points))
    return name


def _names() -> Iterator[str]:
    alphabet = "abcdefghijklmnopqrstuvw"  # x and y are what the functions are of
    yield from alphabet
    yield from map("".join, product(alphabet, repeat=2))
