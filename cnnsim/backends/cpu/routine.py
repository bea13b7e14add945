"""Routines on small grids as arrays of numbers, run by one compiled loop without calls from Python.

Each instruction calls the same loop as a single step of a program, so the result is the same bit for bit.
"""

import math
from typing import Any

import numpy as np

from cnnsim.backends.cpu import bits as packed
from cnnsim.backends.cpu import closed, planes
from cnnsim.backends.cpu.bits import Bits
from cnnsim.backends.cpu.boundary import virtual_cells
from cnnsim.backends.cpu.compiled import kernel, tap_records, tap_type
from cnnsim.backends.cpu.neighbourhood import LITERAL, literals, neighbourhood
from cnnsim.network import reach
from cnnsim.operations.routine import Op, Routine, Stores
from cnnsim.support import Array

MOST_CELLS = 4096
"""The most cells of such a grid: on larger ones threads, and memory of few planes, save more than calls from Python."""
DONE = -1
MOST = 1 << 30
"""The largest number in a register whose product fits a register."""
COLUMNS = 10
"""Numbers of an instruction: op, to, p, q, by; first and last record, radius, place of the virtual cells, a flag."""

_pack, _unpack, _logic, _count = (twins.serial for twins in (packed.pack, packed.unpack, packed.logic, packed.count))
_neighbourhood, _closed_form, _clip = neighbourhood.serial, closed.closed_form.serial, planes.clip.serial


@kernel
def go_through(
    code: Array, constants: Array, rules: Array, taps: Array, around: Array, llm: Array, lam: Array, wire: Array
) -> int:
    """Run all instructions; return the number of one whose result is not finite or too large, else `DONE`.

    ``llm`` (planes, n, rows, words), ``lam`` (planes, n, rows, cols), ``wire`` (registers, n); the others as
    `CompiledRoutine` makes them.
    """
    _, n, rows, cols = lam.shape
    one = lam.dtype.type(1)
    no_plane, no_mask = np.empty((1, 1, 0), lam.dtype), np.empty((1, 1, 0), np.bool_)
    for at in range(code.shape[0]):
        op, to, p, q, by = code[at, 0], code[at, 1], code[at, 2], code[at, 3], code[at, 4]
        first, after, r, place, flag = code[at, 5], code[at, 6], code[at, 7], code[at, 8], code[at, 9]
        lines, columns = (
            around[place : place + rows + 2 * r],
            around[place + rows + 2 * r : place + rows + cols + 4 * r],
        )
        if op == Op.LOGIC:
            _logic(by, llm[p], llm[q], llm[to], cols)
        elif op == Op.NEIGHBOURHOOD:
            virtual = (lines, columns, r, by)
            _neighbourhood(llm[p], llm[to], cols, rules[first:after], flag != 0, virtual)
        elif op == Op.BLACK_ABOVE:
            _pack(lam[p], llm[to])
        elif op in (Op.SHADE, Op.SHADE_BY):
            for g in range(n):
                black = wire[p, g] > 0 if op == Op.SHADE_BY else by > 0
                llm[to, g] = ~np.uint64(0) if black else np.uint64(0)
            _logic(12, llm[to], llm[to], llm[to], cols)  # bits beyond the last column are 0
        elif op == Op.VALUES:
            _unpack(llm[p], lam[to], one, -one)
        elif op == Op.CONSTANT:
            lam[to] = constants[by]
        elif op == Op.CONSTANT_BY:
            for g in range(n):
                lam[to, g] = wire[p, g]
        elif op == Op.SETTLE:
            virtual = (lines, columns, r, constants[by + 2])
            cell = (constants[by + 1], math.inf, flag != 0)
            control = (constants[by], no_plane, lam[q], taps[first:after])
            begin = np.int64(0)  # 0 itself has a type of its own, for which the loop would be compiled again
            if not _closed_form(lam[p], lam[to], no_mask, cell, control, virtual, begin, n * rows):
                return at
        elif op == Op.CLIP:
            _clip(lam[p], lam[to])
        elif op in (Op.COUNT, Op.ANY, Op.ALL):
            _count(llm[p], wire[to])
            for g in range(n):
                if op == Op.ANY:
                    wire[to, g] = wire[to, g] > 0
                elif op == Op.ALL:
                    wire[to, g] = wire[to, g] == rows * cols
        elif op == Op.NUMBER:
            wire[to] = by
        else:
            for g in range(n):
                a, b = wire[p, g], wire[q, g]
                if max(abs(a), abs(b)) > MOST:
                    return at
                if op == Op.ADD:
                    wire[to, g] = a + b
                elif op == Op.SUBTRACT:
                    wire[to, g] = a - b
                elif op == Op.MULTIPLY:
                    wire[to, g] = a * b
                else:
                    wire[to, g] = a < b
    return DONE


class CompiledRoutine:
    """A routine as arrays of numbers for one dtype; called with planes and registers it returns its results.

    It returns None where a result is not finite or too large for a register. Run one by one, the steps raise the error
    or use larger numbers.
    """

    def __init__(self, routine: Routine, dtype: np.dtype[Any]) -> None:
        self._shape, self._dtype = routine.shape, dtype
        self._takes, self._results = routine.given, routine.results
        self._rules, self._taps = [np.empty(0, LITERAL)], [np.empty(0, tap_type(dtype))]
        self._around: list[Array] = [np.empty(0, np.int64)]
        self._constants: list[Any] = []
        rows = [self._row(*instruction) for instruction in routine.instructions]
        self._given = (
            np.array(rows, np.int64), np.array(self._constants, dtype), np.concatenate(self._rules),
            np.concatenate(self._taps), np.concatenate(self._around),
        )  # fmt: skip
        n, (height, width) = math.prod(routine.shape[:-2]), routine.shape[-2:]
        self._llm = routine.sizes.llm, n, height, -(-width // 64)
        self._lam = routine.sizes.lam, n, height, width
        self._wire = routine.sizes.wire, n

    def __call__(self, given: Stores) -> Stores | None:
        """Return the planes and registers that are results."""
        llm, lam, wire = (
            np.empty(self._llm, np.uint64),
            np.empty(self._lam, self._dtype),
            np.empty(self._wire, np.int64),
        )
        for i, plane in zip(self._takes.llm, given.llm, strict=True):
            llm[i] = plane.words
        for i, plane in zip(self._takes.lam, given.lam, strict=True):
            lam[i] = plane
        for i, number in zip(self._takes.wire, given.wire, strict=True):
            wire[i] = number
        if go_through(*self._given, llm, lam, wire) != DONE:
            return None
        return Stores(
            [Bits(llm[i], self._shape) for i in self._results.llm],
            [lam[i].reshape(self._shape) for i in self._results.lam],
            wire[self._results.wire, 0].tolist() if self._results.wire else [],
        )

    def _row(self, op: Op, to: int, p: int, q: int, by: Any) -> tuple[Any, ...]:
        if op is Op.NEIGHBOURHOOD:
            rule, boundary = by
            place = self._put_around(rule.radius, boundary)
            first, after = _put(self._rules, literals(rule))
            return op, to, p, q, int(boundary.u > 0), first, after, rule.radius, place, rule.conjunction
        if op is Op.SETTLE:
            template = by.template
            r = reach((tap.k, tap.l) for tap in template.control_taps)
            place = self._put_around(r, by.boundary)
            first, after = _put(self._taps, tap_records(template.control_taps, self._dtype))
            start = self._put_constants(template.z, template.self_feedback, by.boundary.u)
            return op, to, p, q, start, first, after, r, place, by.cell == "full-range"
        if op is Op.CONSTANT:
            by = self._put_constants(by)
        if op is Op.SHADE:
            by = by > 0
        return op, to, p, q, 0 if by is None else int(by), 0, 0, 0, 0, 0

    def _put_constants(self, *values: float) -> int:
        self._constants += values
        return len(self._constants) - len(values)

    def _put_around(self, r: int, boundary: Any) -> int:
        rows, cols, *_ = virtual_cells(self._shape, r, boundary, 0)
        return _put(self._around, np.concatenate([rows, cols]))[0]


def _put(parts: list[Array], more: Array) -> tuple[int, int]:
    """Append an array; return its first record and the one after its last."""
    first = sum(part.size for part in parts)
    parts.append(more)
    return first, first + more.size
