"""Basic blocks of a program: steps without a branch, translated into one routine.

Logic, neighbourhoods, closed forms, wires and registers become instructions on numbered planes; where the backend fuses
them, so do cellwise steps, transients with a time loop, and repeated steps. Other steps stay as they are.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.routine import FusedCellwise, Instruction, Op, Routine, Stores
from cnnsim.planning.plan import Plan
from cnnsim.program.liveness import reads_and_writes
from cnnsim.program.numbering import numbered
from cnnsim.program.program import (
    CellwiseStep,
    CopyStep,
    FillStep,
    LogicStep,
    NumberStep,
    Program,
    ProgramMemory,
    RepeatStep,
    Step,
    TemplateStep,
    WireStep,
)

FEWEST = 2
"""Instructions from which on a routine is faster than its steps."""
_WIRES = {"any": Op.ANY, "all": Op.ALL, "count": Op.COUNT}
_NUMBERS = {"add": Op.ADD, "subtract": Op.SUBTRACT, "multiply": Op.MULTIPLY, "less": Op.LESS}
_FILLS = {"llm": (Op.SHADE, Op.SHADE_BY), "lam": (Op.CONSTANT, Op.CONSTANT_BY)}
_MEMORIES: tuple[ProgramMemory, ...] = ("llm", "lam", "wire")

MOST_REPEATED = 64
"""Instructions of a repeated step in a routine, all rounds counted."""

Direct = Callable[[TemplateStep], BitRule | Plan | None]
"""Returns the rule of a template step, or its plan; None if it has no instruction."""


@dataclass(frozen=True, eq=False)
class BasicBlock:
    """Some steps of a program as a routine; the names that it takes and gives."""

    steps: tuple[Step, ...]
    routine: Routine
    takes: Stores
    gives: Stores

    def run(self, compiled: Callable[[Stores], Stores | None], planes: dict[str, Any]) -> bool:
        """Run the compiled routine on planes and registers by name; return False if it gave no result."""
        out = compiled(Stores(*([planes[name] for name in names] for names in self.takes)))
        if out is None:
            return False
        for names, values in zip(self.gives, out, strict=True):
            planes.update(zip(names, values, strict=True))
        return True


def basic_blocks(
    program: Program, steps: tuple[Step, ...], shape: tuple[int, ...], direct: Direct, *, fuses: bool = False
) -> list[BasicBlock | Step]:
    """Return the steps of a program, or of one of its loops or branches, in their order, grouped into basic blocks.

    ``fuses`` as `Backend.fuses`.
    """
    found: list[BasicBlock | Step] = []
    group: list[Step] = []
    for step in (*steps, None):
        if step is not None and _has_instructions(program, step, shape, direct, fuses):
            group.append(step)
            continue
        if group:
            block = _block(program, tuple(group), shape, direct)
            found += group if len(block.routine.instructions) < FEWEST else [block]
            group = []
        if step is not None:
            found.append(step)
    return found


def _has_instructions(
    program: Program, step: Step, shape: tuple[int, ...], direct: Direct, fuses: bool
) -> bool:  # fmt: skip
    match step:
        case TemplateStep():
            return direct(step) is not None
        case LogicStep() | CopyStep():
            return True
        case FillStep(value=value, to=to):  # n grids have registers of their own
            return fuses or len(shape) == 2 or not (isinstance(value, str) or program.memory[to] == "wire")
        case WireStep():
            return fuses or len(shape) == 2
        case NumberStep():
            return len(shape) == 2
        case CellwiseStep(operation=operation):
            return fuses and bool(operation.opencl)
        case RepeatStep(times=times, do=do):
            few = times * len(do) <= MOST_REPEATED
            return fuses and few and all(_has_instructions(program, one, shape, direct, fuses) for one in do)
    return False


def _block(program: Program, steps: tuple[Step, ...], shape: tuple[int, ...], direct: Direct) -> BasicBlock:
    writer = _Writer(program, direct)
    for step in steps:
        writer.add(step)
    inside = {id(step) for _, step in numbered(steps)}
    read = {*program.outputs, *program.keep, *(name for names in writer.takes.values() for name in names)}
    for _, step in numbered(program.steps):
        if id(step) not in inside:
            read |= reads_and_writes(step)[0]
    wrote = writer.wrote
    gives = {
        memory: [name for name in wrote if program.memory[name] == memory and name in read] for memory in _MEMORIES
    }
    routine = Routine(
        shape, tuple(writer.instructions),
        Stores(**writer.sizes),
        Stores(**{memory: list(names.values()) for memory, names in writer.takes.items()}),
        Stores(**{memory: [writer.place[name] for name in names] for memory, names in gives.items()}),
    )  # fmt: skip
    return BasicBlock(steps, routine, Stores(**{m: list(names) for m, names in writer.takes.items()}), Stores(**gives))


class _Writer:
    """Writes a routine; each name stands for the plane or register that was last written under it."""

    def __init__(self, program: Program, direct: Direct) -> None:
        self._memory, self._direct = program.memory, direct
        self.instructions: list[Instruction] = []
        self.sizes: dict[ProgramMemory, int] = dict.fromkeys(_MEMORIES, 0)
        self.takes: dict[ProgramMemory, dict[str, int]] = {memory: {} for memory in _MEMORIES}
        self.place: dict[str, int] = {}
        self.wrote: dict[str, None] = {}

    def add(self, step: Step) -> None:
        """Append the instructions of a step."""
        memory, of = self._memory, self._find
        match step:
            case RepeatStep(times=times, do=do):
                for one in do * times:
                    self.add(one)
                return
            case CellwiseStep(operation=operation, of=names, to=results, parameters=parameters):
                given = tuple(map(of, names))
                made = tuple(self._new("lam") for _ in results)
                fused = FusedCellwise(operation, given, made, parameters)
                self.instructions.append(Instruction(Op.CELLWISE, made[0], given[0], by=fused))
                self.place.update(zip(results, made, strict=True))
                self.wrote.update(dict.fromkeys(results))
                return
            case TemplateStep(to=to):
                self.place[to] = self._template(step)
            case LogicStep(function=function, p=p, q=q, to=to):
                self.place[to] = self._put("llm", Op.LOGIC, of(p), of(q), function)
            case CopyStep(source=source, to=to):
                if memory[source] == memory[to]:
                    self.place[to] = of(source)
                elif memory[to] == "llm":
                    self.place[to] = self._put("llm", Op.BLACK_ABOVE, of(source))
                else:
                    self.place[to] = self._values(source)
            case FillStep(value=value, to=to):
                if memory[to] == "wire":
                    self.place[to] = self._put("wire", Op.NUMBER, by=value)
                elif isinstance(value, str):
                    self.place[to] = self._put(memory[to], _FILLS[memory[to]][1], of(value))
                else:
                    self.place[to] = self._put(memory[to], _FILLS[memory[to]][0], by=value)
            case WireStep(wire=wire, of=plane, to=to):
                self.place[to] = self._put("wire", _WIRES[wire], of(plane))
            case NumberStep(function=function, of=numbers, to=to):
                a, b = (of(n) if isinstance(n, str) else self._put("wire", Op.NUMBER, by=n) for n in numbers)
                self.place[to] = self._put("wire", _NUMBERS[function], a, b)
        self.wrote[step.to] = None  # type: ignore[union-attr]  # one name each

    def _template(self, step: TemplateStep) -> int:
        direct, u = self._direct(step), step.input
        if isinstance(direct, BitRule):
            assert isinstance(u, str)  # a rule has an input plane
            return self._put("llm", Op.NEIGHBOURHOOD, self._find(u), by=(direct, step.boundary))
        x = self._values(step.state)
        op = Op.STEPS if isinstance(direct, Plan) and direct.method == "stepped" else Op.SETTLE
        end = self._put("lam", op, x, x if u is None else self._values(u), direct)
        llm = self._memory[step.to] == "llm"
        return self._put("llm", Op.BLACK_ABOVE, end) if llm else self._put("lam", Op.CLIP, end)

    def _put(self, memory: ProgramMemory, op: Op, p: int = 0, q: int = 0, by: object = None) -> int:
        self.instructions.append(Instruction(op, self._new(memory), p, q, by))
        return self.instructions[-1].to

    def _new(self, memory: ProgramMemory) -> int:
        self.sizes[memory] += 1
        return self.sizes[memory] - 1

    def _find(self, name: str) -> int:
        if name not in self.place:
            memory = self._memory[name]
            self.place[name] = self.takes[memory][name] = self._new(memory)
        return self.place[name]

    def _values(self, name: str | float) -> int:
        """Return the number of the LAM plane with the values of a named plane, or with a constant."""
        if not isinstance(name, str):
            return self._put("lam", Op.CONSTANT, by=name)
        at = self._find(name)
        return at if self._memory[name] == "lam" else self._put("lam", Op.VALUES, at)
