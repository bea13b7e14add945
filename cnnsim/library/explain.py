"""Explanation of a template on a grid: plan, memory and guaranteed running time, without computing."""

from dataclasses import dataclass
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.library.catalogue import load
from cnnsim.library.entry import LibraryEntry
from cnnsim.network import AnyTemplate, layered
from cnnsim.planning.plan import Plan, lines_of
from cnnsim.planning.scheme import EULER
from cnnsim.planning.stability import ASTRAY, late_growth
from cnnsim.solver.rest_distance import solving_bytes
from cnnsim.support import Array, InputError
from cnnsim.support.memory import free_memory, in_words
from cnnsim.support.values import is_grey
from cnnsim.task import Task, TaskOptions, make_task
from cnnsim.theory.running_time import RunningTime

COUNTED = ("cpu", "opencl")
"""The backends whose memory is counted; the reference backend is for small grids."""

_NO_SLEEP = "no sleep", "on a GPU the list of sleeping tiles costs more than their steps"


@dataclass(frozen=True, repr=False)
class Explanation:
    """A ``plan`` with its decisions, and the ``guaranteed`` running time; ``str`` has a line for each.

    ``cell_bytes``: memory per cell in float32 on the ``backend``, including arguments and result; ``cells`` of all
    layers; ``grey``: whether the initial state is not black and white; ``on_gpu``: whether the backend's device is one.
    """

    plan: Plan
    guaranteed: RunningTime
    cell_bytes: float
    cells: int
    backend: str = "cpu"
    grey: bool = False
    on_gpu: bool = False

    @property
    def memory(self) -> str:
        """The memory of a run as a text; with the free memory if that is less."""
        size, free = self.cell_bytes * self.cells, free_memory()
        words = f"{self.cell_bytes:.3g} bytes a cell in float32 on {self.backend}, "
        words += f"pictures and result included: {in_words(size)}"
        if self.plan.duration == "settled" and self.plan.method == "stepped" and self.plan.cell != "discrete-time":
            words += (
                f"; where outputs stay grey up to {solving_bytes(self.plan)} bytes a cell more, to solve for the rest"
            )
        return words if size <= free else f"{words}, more than the {in_words(free)} that are free"

    @property
    def growth(self) -> str:
        """The error of Euler's steps for patterns that grow from a grey state, as a text; empty if it is small."""
        plan = self.plan
        if not self.grey or plan.method != "stepped" or plan.template.uncoupled or plan.scheme != EULER:
            return ""
        rate, lost = late_growth(plan.template, plan.step)
        if lost <= ASTRAY:
            return ""
        words = f"patterns grow by up to {rate:.3g} a time constant, of which steps of {plan.step:g} lose {lost:.0%}"
        return f"{words}: from grey states another of them may win; accuracy= follows them"

    @property
    def lines(self) -> list[tuple[str, str]]:
        """Pairs of a title and a text."""
        growth = [("growth", self.growth)] if self.growth else []
        decisions = [_NO_SLEEP if self.on_gpu and what == "sleep" else (what, why) for what, why in self.plan.decisions]
        return [*decisions, *growth, ("memory", self.memory), ("guaranteed time", str(self.guaranteed))]

    def __repr__(self) -> str:
        return lines_of(self.lines)


def explain_template(
    template: str | LibraryEntry | AnyTemplate, picture: ArrayLike = (64, 64), backend: str = "cpu",
    **changes: Unpack[TaskOptions],
) -> Explanation:  # fmt: skip
    """Return the explanation of a template; arguments and errors as in `cnnsim.program.explain.explain`."""
    values = np.asarray(picture)
    values = blank(values) if values.ndim == 1 else values
    if not isinstance(template, str | LibraryEntry):
        layers = len(layered(template).layers)
        state = np.broadcast_to(values, (layers, *values.shape[-2:])) if layers > 1 else values
        choices: TaskOptions = {"input": state, **changes}
        why = "a file says what u and x(0) are; this template has none"
        return _explained(make_task(template, state=state, **choices), RunningTime(None, why), backend)
    entry = load(template) if isinstance(template, str) else template
    if entry.frame_time and values.ndim == 2:
        values = np.broadcast_to(values, (2, *values.shape))
    roles = entry.initial_state if isinstance(entry.initial_state, tuple) else (entry.initial_state,)
    planes = entry.task(values, np.broadcast_to(-1.0, values.shape[-2:]) if "given" in roles else None)
    task = make_task(entry.network, **entry.changed(planes, changes))
    return _explained(task, entry.running_time(task.plan.shape), backend)


def _explained(task: Task, guaranteed: RunningTime, backend: str) -> Explanation:
    if backend not in COUNTED:
        raise InputError(f"backend {backend!r}: its memory is not counted; one of {', '.join(COUNTED)} wanted")
    size = task.cell_bytes(np.dtype(np.float32).itemsize, backend)
    grey, on_gpu = is_grey(task.state), backend == "opencl" and _default_is_gpu()
    return Explanation(task.plan, guaranteed, size, task.state.size, backend, grey=grey, on_gpu=on_gpu)


def _default_is_gpu() -> bool:
    """Return whether the default OpenCL device is a GPU."""
    from cnnsim.backends.opencl.device.devices import devices  # brings pyopencl

    return any(device.chosen and device.family == "gpu" for device in devices())


def blank(shape: Array) -> Array:
    """Return a white picture of a shape that takes no memory."""
    sizes = shape.tolist()
    try:
        if shape.dtype.kind not in "iu" or min(sizes, default=1) < 1:
            raise ValueError
        return np.broadcast_to(-1.0, sizes)
    except ValueError as error:  # also for too many cells
        raise InputError(f"shape {tuple(sizes)}; (rows, cols) of a grid wanted") from error
