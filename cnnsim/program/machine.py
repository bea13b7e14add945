"""UniversalMachine: runs analogic programs step by step. `_execute` has what each kind of step does."""

import math
from dataclasses import replace
from difflib import get_close_matches
from typing import Any, assert_never

import numpy as np
from numpy.typing import ArrayLike

from cnnsim import backends, library
from cnnsim.accuracy.at_rest import seen_to_the_end
from cnnsim.accuracy.reach import Transient
from cnnsim.accuracy.settle import SETTLED_DISTANCE
from cnnsim.accuracy.wanted import Wanted, parse_accuracy
from cnnsim.backends.base import Backend, Outcome, Plane
from cnnsim.ended import reached
from cnnsim.keywords import spelled
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.global_wire import read_wire
from cnnsim.operations.logic import function_number
from cnnsim.planning.plan import Plan, make_plan
from cnnsim.program.bit_steps import rule_of
from cnnsim.program.program import (
    ARITHMETIC,
    BranchStep,
    CellwiseStep,
    CopyStep,
    FillStep,
    LogicStep,
    NumberStep,
    Program,
    RepeatStep,
    Step,
    TemplateStep,
    UntilUnchangedStep,
    WireStep,
)
from cnnsim.support import Array, InputError, naming
from cnnsim.support.memory import LARGE, check_memory
from cnnsim.support.progress import watcher
from cnnsim.support.values import as_numbers
from cnnsim.task import Dtype

_XOR = function_number("xor")


class UniversalMachine:
    """A cellular neural network with memories, a logic unit and a program store, on one backend.

    Planes stay on the backend while a program runs. What a program keeps (see `Program`) lives here from run to run;
    `reset` forgets it. Arguments: ``backend`` a name or a backend; ``dtype`` the numbers it computes with, None for its
    own; ``threads`` of the cpu backend, None for as many as pay. Roska and Chua, "The CNN universal machine", IEEE
    Trans. CAS-II 40 (1993) 163.
    """

    @spelled()
    def __init__(
        self, backend: str | Backend = "cpu", dtype: Dtype | None = None, *, threads: int | None = None
    ) -> None:
        self.backend = backends.get(backend, dtype, threads=threads) if isinstance(backend, str) else backend
        self._kept: dict[Program, dict[str, Plane]] = {}
        self._plans: dict[tuple[TemplateStep, tuple[int, ...]], Plan] = {}
        self._rules: dict[TemplateStep, BitRule | None] = {}

    def reset(self) -> None:
        """Forget all kept planes."""
        self._kept.clear()

    def kept(self, program: Program) -> dict[str, Array]:
        """Return the planes that a program kept in its last run: floats from a LAM, booleans from an LLM."""
        kept = self._kept.get(program, {})
        return {name: self.backend.read(plane) for name, plane in kept.items() if name}

    def run(self, program: Program, **inputs: ArrayLike) -> dict[str, Any]:
        """Run a program on planes (rows, cols) of one shape and return its outputs: arrays, and numbers from wires.

        Planes (n, rows, cols) are n grids that know nothing of each other; wires then give (n,) numbers, and steps that
        ask a wire what to do are errors.

        Raises:
            InputError: an input is missing, unknown or of another shape; a step fails (the message names it).
        """
        arrays = _check(program, inputs)
        shape = next(iter(arrays.values())).shape
        if math.prod(shape) >= LARGE:
            _check_memory(program, shape, self.backend.dtype.itemsize)
        planes: dict[str, Any] = {
            name: self.backend.load(array, program.memory[name])  # type: ignore[arg-type]  # inputs are never wires
            for name, array in arrays.items()
        }
        kept = self._kept.get(program)
        if kept is None or kept[""] != shape:
            kept = {name: self._constant(program, name, value, shape) for name, value in program.keep.items()}
        planes.update(kept)
        planes[""] = shape
        self._execute(program, program.steps, planes)
        self._kept[program] = {name: planes[name] for name in ("", *program.keep)}
        return {
            name: planes[name] if program.memory[name] == "wire" else self.backend.read(planes[name])
            for name in program.outputs
        }

    def _execute(self, program: Program, steps: tuple[Step, ...], planes: dict[str, Any]) -> None:
        backend, memory, watched_by = self.backend, program.memory, watcher()
        for step in steps:
            if watched_by is not None:
                watched_by(None, step.where)
            match step:
                case TemplateStep(to=to, input=u):
                    rule = self._rule(program, step)
                    if rule is not None:
                        planes[to] = backend.neighbourhood(rule, step.boundary, planes[u])  # type: ignore[index]  # a rule has an input plane
                        continue
                    x = self._transient(program, step, planes)
                    planes[to] = backend.output(x) if memory[to] == "lam" else backend.convert(x, "llm")
                case CellwiseStep(operation=operation, of=of, to=to, parameters=parameters):
                    planes.update(
                        zip(to, backend.cellwise(operation, [planes[p] for p in of], parameters), strict=True)
                    )
                case LogicStep(function=function, p=p, q=q, to=to):
                    planes[to] = backend.logic(function, planes[p], planes[q])
                case CopyStep(source=source, to=to):
                    same = memory[source] == memory[to]
                    planes[to] = planes[source] if same else backend.convert(planes[source], memory[to])  # type: ignore[arg-type]  # wires are not copied
                case FillStep(value=value, to=to):
                    number = planes[value] if isinstance(value, str) else value
                    planes[to] = number if memory[to] == "wire" else self._constant(program, to, number, planes[""])
                case WireStep(wire=wire, of=of, to=to):
                    planes[to] = read_wire(wire, backend.count(planes[of]), math.prod(planes[""][-2:]))
                case NumberStep(function=function, of=of, to=to):
                    numbers = [planes[n] if isinstance(n, str) else n for n in of]
                    if any(isinstance(n, np.ndarray) for n in numbers):  # a number for each grid of a batch
                        planes[to] = np.vectorize(ARITHMETIC[function], otypes=[np.int64])(*numbers)
                    else:
                        planes[to] = ARITHMETIC[function](*numbers)
                case RepeatStep(times=times, do=do):
                    for _ in range(times):
                        self._execute(program, do, planes)
                case UntilUnchangedStep():
                    self._until_unchanged(program, step, planes)
                case BranchStep(register=register, do=do, otherwise=otherwise):
                    if len(planes[""]) == 3:
                        raise InputError(f"{step.where}: grids of a batch may go different ways; run them one by one")
                    self._execute(program, do if planes[register] else otherwise, planes)
                case _:
                    assert_never(step)

    def _rule(self, program: Program, step: TemplateStep) -> BitRule | None:
        """Return `rule_of`, found once."""
        if step not in self._rules:
            self._rules[step] = rule_of(program, step)
        return self._rules[step]

    def _transient(self, program: Program, step: TemplateStep, planes: dict[str, Any]) -> Plane:
        shape = planes[""]
        plan = self._plans.get((step, shape))
        if plan is None:
            plan = self._plans[step, shape] = make_plan(
                step.template, shape, step.boundary, duration=step.duration, cell=step.cell,
                step=None if step.accuracy is not None else step.step,
                limit=_limit(step, shape[-2:]),
            )  # fmt: skip

        def plane(name: str | float | None) -> Plane:
            if isinstance(name, str):
                return planes[name] if program.memory[name] == "lam" else self.backend.convert(planes[name], "lam")
            return None if name is None else self.backend.load(np.full(shape, name), "lam")

        mask = None if step.mask is None else planes[step.mask]
        if step.mask is not None and program.memory[step.mask] == "lam":
            mask = self.backend.convert(mask, "llm")
        with naming(step.where):
            x, u, bias = plane(step.state), plane(step.input), plane(step.bias)
            if step.accuracy is not None:
                return self._to_accuracy(plan, parse_accuracy(step.accuracy), x, u, bias, mask)
            outcome = self.backend.transient(plan, x, u, bias, mask)
            if outcome.settled:
                outcome, _ = seen_to_the_end(self.backend, plan, outcome, u, bias, mask, SETTLED_DISTANCE)
        if step.duration == "settled" and not outcome.settled:
            raise InputError(
                f"{step.where}: has not settled after {outcome.t:g} time constants; |dx/dt| {outcome.rate:.3g}"
            )
        return outcome.x

    def _to_accuracy(self, plan: Plan, wanted: Wanted, *planes: Plane | None) -> Plane:
        """Run a transient to an accuracy, in float64 where it must be, and return its state."""
        read = [None if plane is None else self.backend.read(plane) for plane in planes]
        x, u, bias = (None if plane is None else plane.astype(np.float64) for plane in read[:3])

        def start(where: Backend, again: Plan) -> Outcome:
            state, shown, added = (None if plane is None else where.load(plane, "lam") for plane in (x, u, bias))
            return where.transient(again, state, shown, added, None if read[3] is None else where.load(read[3], "llm"))

        found = reached(Transient(plan, start, (x, u, bias, read[3])), self.backend, wanted)
        return self.backend.load(found.x.astype(self.backend.dtype), "lam")

    def _until_unchanged(self, program: Program, step: UntilUnchangedStep, planes: dict[str, Any]) -> None:
        if len(planes[""]) == 3:
            raise InputError(f"{step.where}: grids of a batch may take different times; run them one by one")
        for _ in range(step.limit):
            before = planes[step.plane]
            self._execute(program, step.do, planes)
            if not self.backend.count(self.backend.logic(_XOR, before, planes[step.plane])):
                return
        raise InputError(f"{step.where}: still changing after {step.limit} rounds")

    def _constant(self, program: Program, name: str, value: float | Array, shape: tuple[int, ...]) -> Plane:
        each = value[:, None, None] if isinstance(value, np.ndarray) else value
        return self.backend.load(np.full(shape, each), program.memory[name])  # type: ignore[arg-type]  # planes only


def _check(program: Program, inputs: dict[str, ArrayLike]) -> dict[str, Array]:
    if set(inputs) != set(program.inputs):
        near = [get_close_matches(name, program.inputs, 1) for name in inputs if name not in program.inputs]
        hint = f"; did you mean {' and '.join(repr(match[0]) for match in near if match)}?" if any(near) else ""
        raise InputError(
            f"program {program.name!r} got {', '.join(inputs) or 'nothing'}; {', '.join(program.inputs)} wanted{hint}"
        )
    arrays = {name: as_numbers(name, inputs[name], logic=program.memory[name] == "llm") for name in program.inputs}
    shapes = {name: array.shape for name, array in arrays.items()}
    if len(set(shapes.values())) > 1 or any(array.ndim not in (2, 3) or not array.size for array in arrays.values()):
        raise InputError(f"program {program.name!r} got planes of shapes {shapes}; one shape (rows, cols) wanted")
    return arrays


def _check_memory(program: Program, shape: tuple[int, ...], itemsize: int) -> None:
    """Refuse a grid whose planes, and those of a transient's steps, need more memory than is free."""
    kinds = list(program.memory.values())
    cell = (kinds.count("lam") + 3) * itemsize + kinds.count("llm") / 8
    cure = "a smaller grid, float32 for float64, or a machine with more memory wanted"
    check_memory(f"program {program.name!r} on {' x '.join(map(str, shape))} cells", cell * math.prod(shape), cure)


def _limit(step: TemplateStep, grid: tuple[int, int]) -> float | None:
    """Return how long a step waits for rest: a template of the library for its guaranteed time, if that is longer."""
    if not step.name or step.duration != "settled":
        return None
    entry = replace(library.load(step.name), boundary=step.boundary)
    return entry.limit(grid, has_mask=step.mask is not None)
