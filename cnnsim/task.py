"""Task: the checked planes of a transient and its plan, for any backend."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.backends.base import Backend, Outcome
from cnnsim.backends.memory import cell_bytes
from cnnsim.network import ZERO_FLUX, AnyTemplate, Boundary, Cell, CellModel, Frames
from cnnsim.network.layers import check_template
from cnnsim.network.sides import NO_CELLS, Sides, parse_run_boundary
from cnnsim.planning.plan import Plan, make_plan
from cnnsim.planning.step import Duration
from cnnsim.recording import recorded
from cnnsim.result import Result
from cnnsim.solver.problem import TransientProblem
from cnnsim.solver.solve import decision, solve_at
from cnnsim.solver.tolerance import Accuracy, Tolerance, parse_accuracy
from cnnsim.support import Array, Flags, Floats, InputError
from cnnsim.support.memory import LARGE, check_memory
from cnnsim.support.values import as_numbers, is_grey, largest
from cnnsim.trajectories import CellIndex, Trajectory


@dataclass(frozen=True)
class Task:
    """A template with its planes checked and its plan made, ready for any backend."""

    plan: Plan
    state: Array
    input: Array | Frames[Array] | None
    bias: Array | Frames[Array] | None
    mask: Flags | None
    accuracy: Tolerance | None = None

    def owned(self) -> "Task":
        """Return the task with copies of its planes, which the caller may change during a run."""

        def own(value: Any) -> Any:
            return value.map(own) if isinstance(value, Frames) else None if value is None else value.copy()

        return replace(self, state=own(self.state), input=own(self.input), bias=own(self.bias))

    @property
    def planes(self) -> list[Array]:
        """The distinct planes: often the input is the state."""
        values = (self.state, self.input, self.bias)
        planes = [p for value in values for p in (value.planes if isinstance(value, Frames) else (value,))]
        return list({id(plane): plane for plane in planes if plane is not None}.values())

    def cell_bytes(self, itemsize: int, backend: str = "cpu") -> float:
        """Return the bytes a cell of a run with its planes and result, in numbers of ``itemsize`` bytes."""
        return cell_bytes(self.plan, len(self.planes), itemsize, has_mask=self.mask is not None, backend=backend)

    def check_memory(self, backend: Backend) -> None:
        """Refuse a run on a large grid that needs more memory than is free, before the machine swaps.

        Raises:
            InputError: too little memory is free; the message has both sizes and a remedy.
        """
        if self.state.size < LARGE:
            return
        there = sum(plane.dtype == backend.dtype and plane.flags.c_contiguous for plane in self.planes)
        needed = self.cell_bytes(backend.dtype.itemsize, backend.name) - there * backend.dtype.itemsize
        name, size = self.plan.template.name, " x ".join(map(str, self.state.shape))
        cure = "a smaller grid, float32 for float64, or blocks on the disk (engine='processes', --engine) wanted"
        check_memory(f"template {name!r} on {size} cells", needed * self.state.size, cure)

    def start(self, backend: Backend, state: Array | None = None, plan: Plan | None = None) -> Outcome:
        """Load the planes and run; ``state`` and ``plan`` replace the task's own (to continue from an earlier end)."""
        self.check_memory(backend)
        given = self.state if state is None else state
        x = backend.load(given, "lam", copy=False)
        return backend.transient(
            self.plan if plan is None else plan,
            x,
            x if self.input is given else load(backend, self.input),
            load(backend, self.bias),
            None if self.mask is None else backend.load(self.mask, "llm"),
        )

    def problem(self) -> TransientProblem:
        """Return the transient as a problem to be solved to an accuracy, in float64 unless it is large."""
        finely = self.accuracy is not None and (self.accuracy.dtype == "float64" or self.state.size < LARGE)

        def fine(value: Any) -> Any:
            if isinstance(value, Frames):
                return value.map(fine)
            return value if value is None or not finely else value.astype(np.float64, copy=False)

        given = fine(self.state), fine(self.input), fine(self.bias), self.mask
        return TransientProblem(self.plan, lambda backend, plan, state=None, /: self.start(backend, state, plan), given)

    def recorded(self, backend: Backend, wanted: tuple[CellIndex, ...] | Floats, result: Result) -> Trajectory:
        """Return states at times, or of cells at every step, of a run that ended as ``result``."""

        def end(x: Array, plan: Plan) -> Array:
            return backend.read(self.start(backend, x, plan).x)

        sequences = any(isinstance(value, Frames) for value in (self.input, self.bias))
        first = backend.read(backend.load(self.state, "lam"))
        return recorded(self.plan, first, end, wanted, result.t, result.y, sequences=sequences)

    def states(self, backend: Backend, until: float, frames: int, *, first: int = 0) -> Iterator[tuple[float, Array]]:
        """Yield (t, x) at ``frames`` evenly spaced times up to ``until``; with terms after ``first`` steps or more.

        With an accuracy each state is solved separately.
        """
        old, x = self.plan, self.state
        if self.accuracy is not None:
            for frame in range(1, frames + 1):
                t, found = solve_at(self.problem(), backend, self.accuracy, frame * until / frames)
                yield t, found.x
            return
        if old.method == "general":  # with delays and sequences a run cannot be cut in two, so each state has its own
            for frame in range(1, frames + 1):
                t = max(first, round(frame * until / frames / old.step)) * old.step
                yield t, backend.read(self.start(backend, plan=replace(old, duration=t)).x)
            return
        scheme = old.scheme.name if old.scheme is not None else None
        plan = make_plan(
            old.template, old.shape, old.boundary, duration=until / frames, cell=old.cell,
            scheme="adaptive" if old.method == "adaptive" else scheme, step=old.step if scheme else None,
        )  # fmt: skip
        for frame in range(1, frames + 1):
            x = backend.read(self.start(backend, x, plan).x)
            yield frame * until / frames, x


Dtype = Literal["float32", "float64"]


class TaskOptions(TypedDict, total=False):
    """Options of `make_task` besides template and state; its signature has the defaults."""

    input: ArrayLike | Frames[Any] | None
    bias: ArrayLike | Frames[Any] | None
    mask: ArrayLike | None
    boundary: Boundary | Sides | str
    duration: Duration
    cell: CellModel | Cell
    scheme: str | None
    step: float | None
    limit: float | None
    without: Collection[str]
    accuracy: Accuracy | None


def make_task(
    template: AnyTemplate,
    *,
    state: ArrayLike,
    input: ArrayLike | Frames[Any] | None = None,  # noqa: A002 - the field's word for u
    bias: ArrayLike | Frames[Any] | None = None,
    mask: ArrayLike | None = None,
    boundary: Boundary | Sides | str = ZERO_FLUX,
    duration: Duration = "settled",
    cell: CellModel | Cell = "chua-yang",
    scheme: str | None = None,
    step: float | None = None,
    limit: float | None = None,
    without: Collection[str] = (),
    accuracy: Accuracy | None = None,
) -> Task:
    """Check the planes against each other and plan the transient.

    Arguments: planes (rows, cols) or (n, rows, cols) of one shape, of a network of layers (layers, rows, cols) or
    (n, layers, rows, cols), where a plane (rows, cols) stands for all grids and layers; ``input`` and ``bias`` may be
    `Frames`; ``bias`` is added to z cell by cell; ``mask`` > 0 keeps a cell's state; ``duration`` in time constants or
    ``"settled"`` (see `Plan`), then at most ``limit``;
    ``boundary`` a `Boundary`, `Sides`, or a form of either on the command line;
    ``scheme`` and ``step`` as in `planning.scheme`, or None to let the plan choose; ``without`` as in `make_plan`;
    ``accuracy`` instead of scheme and step: the largest error of a state, ``"binary"`` where only the signs of the
    outputs count, or ``"exact"`` for 1e-10.

    Raises:
        InputError: planes that do not fit or are not finite, a step that cannot be stable.
    """
    check_template(template)
    tolerance = None if accuracy is None else parse_accuracy(accuracy)
    if tolerance is not None and (scheme is not None or step is not None):
        raise InputError(f"accuracy {tolerance} chooses scheme and step; one or the other wanted")
    x = _plane("state", state, None)
    u, w = _planes("input", input, x.shape), _planes("bias", bias, x.shape)
    if u is None and template.reads_input:
        raise InputError(f"template {template.name!r} has a B, or a term of u, so it needs an input plane")
    around = parse_run_boundary(boundary)
    if isinstance(around, Sides):
        w, around = _added(around.bias(template, x.shape), w, x), NO_CELLS
    plan = make_plan(
        template, x.shape, around, duration=duration, cell=cell, scheme=scheme, step=step,
        limit=limit, without=without, periods=[value.period for value in (u, w) if isinstance(value, Frames)],
        grey=lambda: is_grey(x),
    )  # fmt: skip
    if plan.cell == "full-range" and largest(x) > 1:
        raise InputError(f"state reaches {largest(x):g}; the full-range model keeps it from -1 to 1")
    if tolerance is not None:
        plan = replace(plan, decisions=(*plan.decisions, decision(plan, tolerance, x.shape)))
    return Task(plan, x, u, w, None if mask is None else _plane("mask", mask, x.shape) > 0, tolerance)


def _added(virtual: Array, bias: Any, state: Array) -> Any:
    """Return a bias map, or a sequence of them, with the bias of the virtual cells added."""
    if isinstance(bias, Frames):
        return bias.map(lambda plane: plane + virtual)
    return np.broadcast_to(virtual, state.shape) if bias is None else bias + virtual


def load(backend: Backend, value: Any) -> Any:
    """Return a plane, the planes of a sequence, or None, where the backend computes."""
    if isinstance(value, Frames):
        return value.map(lambda plane: backend.load(plane, "lam", copy=False))
    return None if value is None else backend.load(value, "lam", copy=False)


def _planes(name: str, value: Any, shape: tuple[int, ...]) -> Any:
    if isinstance(value, Frames):
        return value.map(lambda plane: _plane(name, plane, shape))
    return None if value is None else _plane(name, value, shape)


def _plane(name: str, values: ArrayLike, shape: tuple[int, ...] | None) -> Array:
    """Return a plane of floats of that shape: the very array that was given where it is one, to save its memory."""
    plane = as_numbers(name, values, levels=name == "bias", logic=name == "mask")
    plane = plane if plane.dtype.kind == "f" else plane.astype(np.float64)
    if shape is not None and (plane.ndim == 0 or (len(shape) > 2 and plane.shape == shape[-2:])):
        plane = np.broadcast_to(plane, shape)
    if plane.ndim not in (2, 3, 4) or plane.size == 0:
        raise InputError(f"{name} has shape {plane.shape}; (rows, cols) with at least one cell wanted")
    if shape is not None and plane.shape != shape:
        raise InputError(f"{name} has shape {plane.shape}, the state has {shape}; one shape wanted")
    if not np.isfinite(largest(plane)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(plane))[0])
        raise InputError(f"{name} holds {plane[where]} in cell {where}; finite numbers wanted")
    return plane
