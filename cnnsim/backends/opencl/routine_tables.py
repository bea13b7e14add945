"""Routines as tables of numbers for routine.cl: instructions, taps and literals, slots of planes, places of results."""

import math
from collections.abc import Sequence
from typing import Any

from cnnsim.backends.codes import boundary_code
from cnnsim.backends.opencl.planes import WORD, words_of
from cnnsim.network import reach
from cnnsim.operations.cellwise import Cellwise
from cnnsim.operations.routine import Instruction, Op, Routine, Stores
from cnnsim.planning.plan import Plan

COLUMNS = 15
"""Numbers of an instruction."""
TRANSFERS = {
    f"{verb}_{memory.upper()}": 100 + 10 * i + j
    for i, verb in enumerate(("LOAD", "STORE"))
    for j, memory in enumerate(Stores._fields)
}
"""Codes of the instructions between global and local memory."""
_OPERANDS: dict[Op, str] = {
    Op.LOGIC: "bbb", Op.NEIGHBOURHOOD: "bb", Op.BLACK_ABOVE: "ba", Op.SHADE: "b", Op.SHADE_BY: "bw", Op.VALUES: "ab",
    Op.CONSTANT: "a", Op.CONSTANT_BY: "aw", Op.SETTLE: "aaa", Op.CLIP: "aa", Op.COUNT: "wb", Op.ANY: "wb", Op.ALL: "wb",
    Op.NUMBER: "w", Op.ADD: "www", Op.SUBTRACT: "www", Op.MULTIPLY: "www", Op.LESS: "www", Op.STEPS: "aaa",
}  # fmt: skip
"""Memories of the result and the operands: b(lack and white), a(nalog), w(ire)."""
_BY_LETTER = {"b": "llm", "a": "lam", "w": "wire"}
Place = tuple[str, int]
"""A memory and the number of a plane or register in it."""


def written_and_read(instruction: Instruction) -> tuple[list[Place], list[Place]]:
    """Return the planes and registers that an instruction writes, and those that it reads."""
    if instruction.op is Op.CELLWISE:
        return [("lam", n) for n in instruction.by.to], [("lam", n) for n in instruction.by.of]
    to, *of = (_BY_LETTER[letter] for letter in _OPERANDS[instruction.op])
    return [(to, instruction.to)], list(zip(of, (instruction.p, instruction.q), strict=False))


class RoutineTables:
    """The tables of a routine for planes of numbers of ``itemsize`` bytes.

    ``code``, ``table`` and ``numbers`` as in routine.cl; the cellwise ``operations``; the number of ``slots`` in each
    memory, which are used again after the last reader of a plane; ``stored``, the byte at which each result begins, a
    multiple of ``align``, in a buffer of ``size`` bytes; ``work``, the sums of a grid.
    """

    def __init__(self, routine: Routine, itemsize: int, align: int) -> None:
        self._grids, self._align = math.prod(routine.shape[:-2]), align
        rows, cols = routine.shape[-2:]
        self._bytes = {"llm": rows * words_of(cols) * WORD // 8, "lam": rows * cols * itemsize, "wire": 8}
        self._cells = rows * cols
        self.table: list[tuple[int, int, int]] = [(0, 0, 0)]
        self.numbers: list[float] = [0.0]
        self.operations: list[Cellwise] = []
        self.slots, self.stored = dict.fromkeys(Stores._fields, 0), dict[Place, int]()
        self.size, self.work = 4 * self._grids, 0.0
        self._slot: dict[Place, int] = {}
        self._free: dict[str, list[int]] = {memory: [] for memory in Stores._fields}
        self._results = {(memory, n) for memory, of in zip(Stores._fields, routine.results, strict=True) for n in of}
        self.code: list[list[int]] = []
        self._write(routine)

    def _write(self, routine: Routine) -> None:
        last: dict[Place, int] = {}
        for at, instruction in enumerate(routine.instructions):
            last.update(dict.fromkeys(written_and_read(instruction)[1], at))
        planes = [("llm", n) for n in routine.given.llm] + [("lam", n) for n in routine.given.lam]
        for number, place in [*enumerate(planes), *enumerate(("wire", n) for n in routine.given.wire)]:
            self.code.append(_row(TRANSFERS[f"LOAD_{place[0].upper()}"], self._new(place), number))
            self._store(place)
        for at, instruction in enumerate(routine.instructions):
            written, read = written_and_read(instruction)
            for place in written:
                self._new(place)
            self.code.append(self._row_of(instruction))
            for place in written:
                self._store(place)
            for place in {*read, *written}:
                if last.get(place, -1) <= at:
                    self._free[place[0]].append(self._slot[place])

    def _new(self, place: Place) -> int:
        free = self._free[place[0]]
        if not free:
            free.append(self.slots[place[0]])
            self.slots[place[0]] += 1
        self._slot[place] = free.pop()
        return self._slot[place]

    def _store(self, place: Place) -> None:
        if place not in self._results or place in self.stored:
            return
        self.stored[place] = begin = -(-self.size // self._align) * self._align
        self.size = begin + self._grids * self._bytes[place[0]]
        self.code.append(_row(TRANSFERS[f"STORE_{place[0].upper()}"], 0, self._slot[place], 0, begin))

    def _row_of(self, instruction: Instruction) -> list[int]:
        op, by, slot = instruction.op, instruction.by, self._slot
        self.work += self._cells
        first = len(self.table)
        if op is Op.CELLWISE:
            self.table += [(0, 0, slot["lam", n]) for n in (*by.of, *by.to)]
            if by.operation not in self.operations:
                self.operations.append(by.operation)
            return _row(op, 0, 0, self._put(*by.parameters), self.operations.index(by.operation), first)
        to, *of = (slot[place] for places in written_and_read(instruction) for place in places)
        p, q = (*of, 0, 0)[:2]
        if op is Op.NEIGHBOURHOOD:
            rule, boundary = by
            self.table += [(k, l, int(negated)) for k, l, negated in rule.literals]
            around = first, len(self.table), boundary_code(boundary)
            return _row(op, to, p, 0, int(boundary.u > 0), *around, int(rule.conjunction))
        if isinstance(by, Plan):
            return _row(op, to, p, q, *self._of_plan(by, settles=op is Op.SETTLE))
        if op is Op.CONSTANT:
            by = self._put(by)
        if op is Op.SHADE:
            by = by > 0
        return _row(op, to, p, q, 0 if by is None else int(by))

    def _of_plan(self, plan: Plan, *, settles: bool) -> tuple[int, ...]:
        *b, reach_b = self._taps(plan.template.control_taps)
        z, u, around = plan.template.z, plan.boundary.u, boundary_code(plan.boundary)
        if settles:
            return self._put(z, plan.template.self_feedback, u), *b, around, 0, 0, 0, 0, 0, reach_b
        assert plan.scheme is not None
        *a, reach_a = self._taps(plan.feedback_taps)
        self.work += plan.steps * self._cells * max(1, a[1] - a[0])
        numbers = self._put(z, u, plan.boundary.y, plan.scheme.gain(plan.step) * plan.scheme.b[0])
        every = plan.check_every if plan.duration == "settled" else 0
        return numbers, *b, around, 0, *a, plan.steps, every, reach_b, reach_a

    def _taps(self, taps: Sequence[Any]) -> tuple[int, int, int]:
        """Append taps to the table; return the first, the one after the last, and the radius."""
        first, number = len(self.table), self._put(*(tap.weight for tap in taps))
        self.table += [(tap.k, tap.l, number + i) for i, tap in enumerate(taps)]
        return first, len(self.table), reach((tap.k, tap.l) for tap in taps)

    def _put(self, *numbers: float) -> int:
        self.numbers += numbers
        return len(self.numbers) - len(numbers)


def _row(*numbers: int) -> list[int]:
    return [*map(int, numbers), *[0] * (COLUMNS - len(numbers))]
