"""UniversalMachine: runs analogic programs step by step. `_execute` has what each kind of step does."""

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, assert_never

import numpy as np
from numpy.typing import ArrayLike

from cnnsim import backends
from cnnsim.accuracy.at_rest import seen_to_the_end
from cnnsim.accuracy.settle import SETTLED_DISTANCE
from cnnsim.accuracy.wanted import parse_accuracy
from cnnsim.backends.base import Backend, Plane
from cnnsim.keywords import spelled
from cnnsim.operations.global_wire import read_wire
from cnnsim.operations.logic import function_number
from cnnsim.program.inputs import check_inputs, check_planes_fit
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
from cnnsim.program.stretch import AtOneGo, Known, Stretch, stretches
from cnnsim.program.template_steps import TemplateSteps
from cnnsim.program.to_accuracy import to_accuracy
from cnnsim.program.words import numbered
from cnnsim.support import Array, InputError, naming
from cnnsim.support.bounds import REGISTER
from cnnsim.support.memory import LARGE
from cnnsim.support.progress import watcher
from cnnsim.task import Dtype

if TYPE_CHECKING:
    from cnnsim.supersteps.engine import Engine

_XOR = function_number("xor")
Part = tuple[AtOneGo | None, Stretch | Step]
"""A step, or a stretch with what the backend does it with at one go, None where step by step is as good."""


class UniversalMachine:
    """A cellular neural network with memories, a logic unit and a program store, on one backend.

    Planes stay on the backend while a program runs. What a program keeps (see `Program`) lives here from run to run;
    `reset` forgets it. Arguments: ``backend`` a name or a backend; ``dtype`` the numbers it computes with, None for its
    own; ``threads`` of the cpu backend, None for as many as pay; ``engine`` and ``store`` as in `run_transient`: planes
    then lie on the disk in blocks, and a machine that was stopped goes on when it runs the same programs again. Roska
    and Chua, "The CNN universal machine", IEEE Trans. CAS-II 40 (1993) 163.
    """

    @spelled()
    def __init__(
        self, backend: str | Backend = "cpu", dtype: Dtype | None = None, *, threads: int | None = None,
        engine: "str | Engine | None" = None, store: str | Path | None = None,
    ) -> None:  # fmt: skip
        self.backend = backends.get(backend, dtype, threads=threads) if isinstance(backend, str) else backend
        self._kept: dict[Program, dict[str, Plane]] = {}
        self._ways, self._on_engine = TemplateSteps(), None
        if engine is not None or store is not None:
            from cnnsim.program.on_engine import OnEngine  # only here: it brings processes and Zarr

            self._on_engine = OnEngine(self.backend, engine or "processes", store, self._ways)
            self.backend = self._on_engine.backend
        self._stretches: dict[tuple[int, tuple[int, ...]], tuple[tuple[Step, ...], list[Part]]] = {}

    def reset(self) -> None:
        """Forget all kept planes."""
        self._kept.clear()

    def kept(self, program: Program) -> dict[str, Array]:
        """Return the planes that a program kept in its last run: floats from a LAM, booleans from an LLM."""
        kept = self._kept.get(program, {})
        return {name: self.backend.read(plane) for name, plane in kept.items() if name}

    def prepare(self, program: Program, shape: tuple[int, ...]) -> None:
        """Find out now how a program's steps are done on planes of this shape, so that its first run need not."""
        for _, step in numbered(program.steps):
            for inside in (step.do, step.otherwise) if isinstance(step, BranchStep) else _within(step):
                self._parts(program, inside, shape)
        self._parts(program, program.steps, shape)

    def run(self, program: Program, **inputs: ArrayLike) -> dict[str, Any]:
        """Run a program on planes (rows, cols) of one shape and return its outputs: arrays, and numbers from wires.

        Planes (n, rows, cols) are n grids that know nothing of each other; wires then give (n,) numbers, and steps that
        ask a wire what to do are errors.

        Raises:
            InputError: an input is missing, unknown or of another shape; a step fails (the message names it).
        """
        if not isinstance(program, Program):
            raise InputError(f"program {program!r}; a Program, as of load_program, wanted")
        arrays = check_inputs(program, inputs, stored=self._on_engine is not None)
        if self._on_engine is not None:
            with self._on_engine.running(program, arrays):
                return self._run(program, arrays)
        shape = next(iter(arrays.values())).shape
        if math.prod(shape) >= LARGE:
            check_planes_fit(program, shape, self.backend.dtype.itemsize)
        return self._run(program, arrays)

    def _run(self, program: Program, arrays: dict[str, Array]) -> dict[str, Any]:
        shape = next(iter(arrays.values())).shape
        planes: dict[str, Any] = {
            name: self.backend.load(array, program.memory[name])  # type: ignore[arg-type]  # inputs are never wires
            for name, array in arrays.items()
        }
        if program.keep:
            kept = self._kept.get(program)
            if kept is None or kept[""] != shape:
                kept = {name: self._constant(program, name, value, shape) for name, value in program.keep.items()}
            planes.update(kept)
        planes[""] = shape
        self._execute(program, program.steps, planes)
        if program.keep:
            self._kept[program] = {name: planes[name] for name in ("", *program.keep)}
        return {
            name: planes[name] if program.memory[name] == "wire" else self.backend.hand_out(name, planes[name])
            for name in program.outputs
        }

    def _execute(self, program: Program, steps: tuple[Step, ...], planes: dict[str, Any]) -> None:
        watched_by = watcher()
        for at_one_go, part in self._parts(program, steps, planes[""]):
            inside = part.steps if isinstance(part, Stretch) else (part,)
            if watched_by is not None and self._on_engine is None:
                watched_by(None, inside[0].where)
            if not (isinstance(part, Stretch) and at_one_go is not None and part.done(at_one_go, planes)):
                for step in inside:
                    self._step(program, step, planes)
                    if self._on_engine is not None:
                        self._on_engine.ended(step, planes)

    def _parts(self, program: Program, steps: tuple[Step, ...], shape: tuple[int, ...]) -> list[Part]:
        """Return the steps, those of a stretch together with what the backend does it with; found once."""
        found = self._stretches.get((id(steps), shape))
        if found is None:  # with the steps, whose id is theirs as long as they are there
            known = Known(partial(self._ways.rule, program), partial(self._ways.plan, shape=shape))
            parts: list[Part] = [
                (self.backend.prepared(part.routine), part) if isinstance(part, Stretch) else (None, part)
                for part in stretches(program, steps, shape, known)
            ]
            found = self._stretches[id(steps), shape] = steps, parts
        return found[1]

    def _step(self, program: Program, step: Step, planes: dict[str, Any]) -> None:
        backend, memory = self.backend, program.memory
        if self._on_engine is not None:
            self._on_engine.begins(step)
        match step:
            case TemplateStep(to=to, input=u):
                rule = self._ways.rule(program, step)
                if rule is not None:
                    planes[to] = backend.neighbourhood(rule, step.boundary, planes[u])  # type: ignore[index]  # a rule has an input plane
                    return
                x = self._transient(program, step, planes)
                planes[to] = backend.output(x) if memory[to] == "lam" else backend.convert(x, "llm")
            case CellwiseStep(operation=operation, of=of, to=to, parameters=parameters):
                planes.update(zip(to, backend.cellwise(operation, [planes[p] for p in of], parameters), strict=True))
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
            case NumberStep(of=of, to=to):
                planes[to] = _number(step, *(planes[n] if isinstance(n, str) else n for n in of))
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

    def _transient(self, program: Program, step: TemplateStep, planes: dict[str, Any]) -> Plane:
        shape, backend = planes[""], self.backend
        plan = self._ways.plan(step, shape)

        def plane(name: str | float | None) -> Plane:
            if isinstance(name, str):
                return planes[name] if program.memory[name] == "lam" else self.backend.convert(planes[name], "lam")
            return None if name is None else self.backend.constant(name, shape, "lam")

        mask = None if step.mask is None else planes[step.mask]
        if step.mask is not None and program.memory[step.mask] == "lam":
            mask = self.backend.convert(mask, "llm")
        with naming(step.where):
            x, u, bias = plane(step.state), plane(step.input), plane(step.bias)
            if step.accuracy is not None:
                return to_accuracy(backend, plan, parse_accuracy(step.accuracy), x, u, bias, mask)
            outcome = backend.transient(plan, x, u, bias, mask)
            if outcome.settled:
                end = partial(seen_to_the_end, backend, plan, outcome, u, bias, mask, SETTLED_DISTANCE)
                outcome = end()[0] if self._on_engine is None else self._on_engine.backend.seen(outcome, end)
        if step.duration == "settled" and not outcome.settled:
            raise InputError(
                f"{step.where}: has not settled after {outcome.t:g} time constants; |dx/dt| {outcome.rate:.3g}"
            )
        return outcome.x

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
        return self.backend.constant(each, shape, program.memory[name])  # type: ignore[arg-type]  # planes only


def _within(step: Step) -> tuple[tuple[Step, ...], ...]:
    """Return the steps that a loop repeats."""
    return (step.do,) if isinstance(step, RepeatStep | UntilUnchangedStep) else ()


def _number(step: NumberStep, p: Any, q: Any) -> Any:
    """Return what a number step comes to: a number, or one for each grid of a batch.

    Raises:
        InputError: no register has room for it.
    """
    found = np.frompyfunc(ARITHMETIC[step.function], 2, 1)(p, q)  # Python's own whole numbers, which never wrap
    if abs(worst := max(np.ravel(found), key=abs)) > REGISTER:
        raise InputError(f"{step.where}: comes to {float(worst):.4g}; registers hold {REGISTER:.4g} at most")
    return found.astype(np.int64) if isinstance(found, np.ndarray) else found
