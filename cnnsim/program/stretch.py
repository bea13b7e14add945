"""Stretches of a program: steps that follow each other straight on, as one routine of operations on numbered planes.

Steps of logic, of neighbours, of cells with a closed form, of wires and registers go into a routine; cellwise ones,
transients with a time loop and all that repeat or choose stay steps.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.routine import Instruction, Op, Routine, Stores
from cnnsim.planning.plan import Plan
from cnnsim.program.program import (
    CopyStep,
    FillStep,
    LogicStep,
    NumberStep,
    Program,
    ProgramMemory,
    Step,
    TemplateStep,
    WireStep,
)
from cnnsim.program.words import numbered

FEWEST = 2
"""Instructions from which on a routine is worth its making."""
_WIRES = {"any": Op.ANY, "all": Op.ALL, "count": Op.COUNT}
_NUMBERS = {"add": Op.ADD, "subtract": Op.SUBTRACT, "multiply": Op.MULTIPLY, "less": Op.LESS}
AtOneGo = Callable[[Stores], Stores | None]
"""See `Backend.prepared`."""
_FILLS = {"llm": (Op.SHADE, Op.SHADE_BY), "lam": (Op.CONSTANT, Op.CONSTANT_BY)}


@dataclass(frozen=True, eq=False)
class Stretch:
    """Some steps of a program and the routine that they are; the names of what it takes and gives."""

    steps: tuple[Step, ...]
    routine: Routine
    takes: Stores
    gives: Stores

    def done(self, at_one_go: AtOneGo, planes: dict[str, Any]) -> bool:
        """Do it on the planes and registers by name, and return whether it could be done at one go."""
        out = at_one_go(Stores(*([planes[name] for name in names] for names in self.takes)))
        if out is None:
            return False
        for names, values in zip(self.gives, out, strict=True):
            planes.update(zip(names, values, strict=True))
        return True


class Known(NamedTuple):
    """How a template step is done on a grid: the AND or OR that it comes down to, if it does, and its plan."""

    rule: Callable[[TemplateStep], BitRule | None]
    plan: Callable[[TemplateStep], Plan]


def stretches(program: Program, steps: tuple[Step, ...], shape: tuple[int, ...], known: Known) -> list[Stretch | Step]:
    """Return the steps in their order, those of a straight stretch together.

    Arguments: ``steps`` of the program, or of one of its loops or branches; ``shape`` of its planes.
    """
    found: list[Stretch | Step] = []
    straight: list[Step] = []
    for step in (*steps, None):
        if step is not None and _is_straight(program, step, shape, known):
            straight.append(step)
            continue
        if straight:
            stretch = _stretch(program, tuple(straight), shape, known)
            found += straight if len(stretch.routine.instructions) < FEWEST else [stretch]
            straight = []
        if step is not None:
            found.append(step)
    return found


def _is_straight(program: Program, step: Step, shape: tuple[int, ...], known: Known) -> bool:
    match step:
        case TemplateStep(bias=bias, mask=mask, duration=duration, accuracy=accuracy):
            if known.rule(step) is not None:
                return True
            alone = bias is None and mask is None and accuracy is None and duration == "settled"
            return alone and step.template.linear and known.plan(step).method == "closed form"
        case LogicStep() | CopyStep():
            return True
        case FillStep(value=value, to=to):  # of n grids each has registers of its own
            return len(shape) == 2 or not (isinstance(value, str) or program.memory[to] == "wire")
        case WireStep() | NumberStep():
            return len(shape) == 2
    return False


def _stretch(program: Program, steps: tuple[Step, ...], shape: tuple[int, ...], known: Known) -> Stretch:
    writer = _Writer(program, known)
    for step in steps:
        writer.add(step)
    inside = set(map(id, steps))
    read = {*program.outputs, *program.keep, *(name for names in writer.takes.values() for name in names)}
    for _, step in numbered(program.steps):
        if id(step) not in inside:
            read |= _reads(step)
    wrote: dict[str, None] = dict.fromkeys(step.to for step in steps)  # type: ignore[union-attr,misc]  # one name each
    gives = {
        memory: [name for name in wrote if program.memory[name] == memory and name in read] for memory in _MEMORIES
    }
    routine = Routine(
        shape, tuple(writer.instructions),
        Stores(**writer.sizes),
        Stores(**{memory: list(names.values()) for memory, names in writer.takes.items()}),
        Stores(**{memory: [writer.place[name] for name in names] for memory, names in gives.items()}),
    )  # fmt: skip
    return Stretch(steps, routine, Stores(**{m: list(names) for m, names in writer.takes.items()}), Stores(**gives))


_MEMORIES: tuple[ProgramMemory, ...] = ("llm", "lam", "wire")


class _Writer:
    """Writes a routine: every name stands for the plane or register that was last written under it."""

    def __init__(self, program: Program, known: Known) -> None:
        self._memory, self._known = program.memory, known
        self.instructions: list[Instruction] = []
        self.sizes: dict[ProgramMemory, int] = dict.fromkeys(_MEMORIES, 0)
        self.takes: dict[ProgramMemory, dict[str, int]] = {memory: {} for memory in _MEMORIES}
        self.place: dict[str, int] = {}

    def add(self, step: Step) -> None:
        """Append what a straight step does."""
        memory, of = self._memory, self.find
        match step:
            case TemplateStep(input=u, state=x0, to=to):
                rule = self._known.rule(step)
                if rule is not None:
                    assert isinstance(u, str)  # a rule has an input plane
                    at = self._put("llm", Op.NEIGHBOURHOOD, of(u), by=(rule, step.boundary))
                else:
                    x = self._values(x0)
                    end = self._put("lam", Op.SETTLE, x, x if u is None else self._values(u), self._known.plan(step))
                    at = (
                        self._put("llm", Op.BLACK_ABOVE, end) if memory[to] == "llm" else self._put("lam", Op.CLIP, end)
                    )
                self.place[to] = at
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

    def _put(self, memory: ProgramMemory, op: Op, p: int = 0, q: int = 0, by: object = None) -> int:
        self.instructions.append(Instruction(op, self._new(memory), p, q, by))
        return self.instructions[-1].to

    def _new(self, memory: ProgramMemory) -> int:
        self.sizes[memory] += 1
        return self.sizes[memory] - 1

    def find(self, name: str) -> int:
        if name not in self.place:
            memory = self._memory[name]
            self.place[name] = self.takes[memory][name] = self._new(memory)
        return self.place[name]

    def _values(self, name: str | float) -> int:
        """Return a LAM plane with what a name or a number stands for."""
        if not isinstance(name, str):
            return self._put("lam", Op.CONSTANT, by=name)
        at = self.find(name)
        return at if self._memory[name] == "lam" else self._put("lam", Op.VALUES, at)


def _reads(step: Step) -> set[str]:
    """Return the names that a step reads itself, not by the steps inside it."""
    said = vars(step)
    names = [
        said.get(key) for key in ("input", "state", "bias", "mask", "p", "q", "source", "value", "plane", "register")
    ]
    of = said.get("of", ())
    names += [of] if isinstance(of, str) else of
    return {name for name in names if isinstance(name, str)}
