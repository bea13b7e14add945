"""Execution of a program on its planes and registers: one case for each kind of step."""

import math
from functools import partial
from typing import TYPE_CHECKING, Any, assert_never

import numpy as np

from cnnsim.backends.base import Backend, Outcome, Plane
from cnnsim.convergence import accurate_result
from cnnsim.network.characteristic import CLIP
from cnnsim.operations.global_wire import read_wire
from cnnsim.operations.logic import function_number
from cnnsim.planning.plan import Plan
from cnnsim.program.basic_block import BasicBlock
from cnnsim.program.block_cache import BlockCache
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
from cnnsim.solver.problem import TransientProblem, largest
from cnnsim.solver.rest_distance import SETTLED_DISTANCE
from cnnsim.solver.tolerance import Tolerance, parse_accuracy
from cnnsim.solver.verify_settled import verify_settled
from cnnsim.support import Array, InputError, naming
from cnnsim.support.limits import REGISTER
from cnnsim.support.notices import Notices
from cnnsim.support.progress import watcher

if TYPE_CHECKING:
    from cnnsim.program.on_engine import OnEngine

_XOR = function_number("xor")


def filled(backend: Backend, program: Program, name: str, value: float | Array, shape: tuple[int, ...]) -> Plane:
    """Return a plane of one number, or of one for each grid of a batch (n,), in the memory that its name has."""
    each = value[:, None, None] if isinstance(value, np.ndarray) else value
    return backend.constant(each, shape, program.memory[name])  # type: ignore[arg-type]  # planes only


class Execution:
    """A program as it runs on planes of one shape.

    Arguments: ``blocks`` compiled for a machine; ``planes`` by name: the inputs and the kept planes at first, then all
    that the steps write; ``on_engine`` for planes on the disk.
    """

    def __init__(
        self, blocks: BlockCache, program: Program, planes: dict[str, Any], shape: tuple[int, ...],
        on_engine: "OnEngine | None" = None,
    ) -> None:  # fmt: skip
        self.planes, self._program, self._shape = planes, program, shape
        self._blocks, self._backend, self._on_engine = blocks, blocks.backend, on_engine

    def run(self, steps: tuple[Step, ...]) -> None:
        """Run steps in order; a basic block runs as its compiled routine, if it has one."""
        planes, watched_by = self.planes, watcher()
        for compiled, part in self._blocks.parts(self._program, steps, self._shape):
            inside = part.steps if isinstance(part, BasicBlock) else (part,)
            if watched_by is not None and self._on_engine is None:
                watched_by(None, inside[0].where)
            if isinstance(part, BasicBlock) and compiled is not None and part.run(compiled, planes):
                continue
            for step in inside:
                self._step(step)
                if self._on_engine is not None:
                    self._on_engine.ended(step, planes)

    def _step(self, step: Step) -> None:
        backend, memory, planes = self._backend, self._program.memory, self.planes
        if self._on_engine is not None:
            self._on_engine.begins(step)
        match step:
            case TemplateStep(to=to, input=u):
                rule = self._blocks.templates.rule(self._program, step)
                if rule is not None:
                    planes[to] = backend.neighbourhood(rule, step.boundary, planes[u])  # type: ignore[index]  # a rule has an input plane
                    return
                x, f = self._transient(step), CLIP if step.cell.model == "discrete-time" else step.cell.output
                if memory[to] == "lam" or f.table is not None:  # of others the state has the output's sign
                    x = backend.output(x, f)
                planes[to] = x if memory[to] == "lam" else backend.convert(x, "llm")
            case CellwiseStep(operation=operation, of=of, to=to, parameters=parameters):
                planes.update(zip(to, backend.cellwise(operation, [planes[p] for p in of], parameters), strict=True))
            case LogicStep(function=function, p=p, q=q, to=to):
                planes[to] = backend.logic(function, planes[p], planes[q])
            case CopyStep(source=source, to=to):
                same = memory[source] == memory[to]
                planes[to] = planes[source] if same else backend.convert(planes[source], memory[to])  # type: ignore[arg-type]  # wires are not copied
            case FillStep(value=value, to=to):
                number = planes[value] if isinstance(value, str) else value
                planes[to] = number if memory[to] == "wire" else filled(backend, self._program, to, number, self._shape)
            case WireStep(wire=wire, of=of, to=to):
                planes[to] = read_wire(wire, backend.count(planes[of]), math.prod(self._shape[-2:]))
            case NumberStep(of=of, to=to):
                planes[to] = _number(step, *(planes[n] if isinstance(n, str) else n for n in of))
            case RepeatStep(times=times, do=do):
                for _ in range(times):
                    self.run(do)
            case UntilUnchangedStep():
                self._until_unchanged(step)
            case BranchStep(register=register, do=do, otherwise=otherwise):
                if len(self._shape) == 3:
                    raise InputError(f"{step.where}: grids of a batch may go different ways; run them one by one")
                self.run(do if planes[register] else otherwise)
            case _:
                assert_never(step)

    def _transient(self, step: TemplateStep) -> Plane:
        backend, memory, planes, shape = self._backend, self._program.memory, self.planes, self._shape
        plan = self._blocks.templates.plan(step, shape)

        def plane(name: str | float | None) -> Plane:
            if isinstance(name, str):
                return planes[name] if memory[name] == "lam" else backend.convert(planes[name], "lam")
            return None if name is None else backend.constant(name, shape, "lam")

        mask = None if step.mask is None else planes[step.mask]
        if step.mask is not None and memory[step.mask] == "lam":
            mask = backend.convert(mask, "llm")
        with naming(step.where):
            x, u, bias = plane(step.state), plane(step.input), plane(step.bias)
            if step.accuracy is not None:
                return _accurate(backend, plan, parse_accuracy(step.accuracy), x, u, bias, mask)
            outcome = backend.transient(plan, x, u, bias, mask)
            if outcome.settled:
                end = partial(verify_settled, backend, plan, outcome, u, bias, mask, SETTLED_DISTANCE)
                outcome = end()[0] if self._on_engine is None else self._on_engine.backend.seen(outcome, end)
        if step.duration == "settled" and not outcome.settled:
            rate = "" if math.isnan(outcome.rate) else f"; |dx/dt| {outcome.rate:.3g}"
            raise InputError(f"{step.where}: has not settled after {outcome.t:g} time constants{rate}")
        return outcome.x

    def _until_unchanged(self, step: UntilUnchangedStep) -> None:
        if len(self._shape) == 3:
            raise InputError(f"{step.where}: grids of a batch may need different numbers of rounds; one grid wanted")
        for _ in range(step.limit):
            before = self.planes[step.plane]
            self.run(step.do)
            if not self._backend.count(self._backend.logic(_XOR, before, self.planes[step.plane])):
                return
        raise InputError(f"{step.where}: still changing after {step.limit} rounds")


def _number(step: NumberStep, p: Any, q: Any) -> Any:
    """Return the result of a number step: a number, or one for each grid of a batch.

    Raises:
        InputError: the result is larger than a register holds.
    """
    found = np.frompyfunc(ARITHMETIC[step.function], 2, 1)(p, q)  # Python's own whole numbers, which never wrap
    if abs(worst := max(np.ravel(found), key=abs)) > REGISTER:
        raise InputError(f"{step.where}: comes to {float(worst):.4g}; registers hold {REGISTER:.4g} at most")
    return found.astype(np.int64) if isinstance(found, np.ndarray) else found


def _accurate(backend: Backend, plan: Plan, tolerance: Tolerance, *planes: Plane | None) -> Plane:
    """Run a transient of state, input, bias and mask to an accuracy, in float64 where needed; return its state.

    It is stored in the machine's own dtype; if that is less precise than the accuracy, a notice is given.
    """
    read = [None if plane is None else backend.read(plane) for plane in planes]
    x, u, bias = (None if plane is None else plane.astype(np.float64) for plane in read[:3])

    def start(where: Backend, again: Plan, state: Array | None = None, /) -> Outcome:
        given = (x if state is None else state, u, bias)
        begin, control, added = (None if plane is None else where.load(plane, "lam") for plane in given)
        return where.transient(again, begin, control, added, None if read[3] is None else where.load(read[3], "llm"))

    found = accurate_result(TransientProblem(plan, start, (x, u, bias, read[3])), backend, tolerance)
    kept = 0.5 * float(np.finfo(backend.dtype).eps) * max(1.0, largest(found.x))
    if not tolerance.signs and tolerance.error < kept and backend.dtype != "float64":
        cure = "the reference backend, or dtype float64, wanted for more"
        Notices.once(
            f"accuracy {tolerance}: planes in memories of {backend.dtype} are rounded by up to {kept:.2g}; {cure}"
        )
    return backend.load(found.x.astype(backend.dtype), "lam")
