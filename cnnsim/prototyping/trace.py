"""Records a transient: the states of a whole plane at evenly spaced times."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnnsim.backends.base import Backend
from cnnsim.cell import output
from cnnsim.errors import InputError
from cnnsim.plan import make_plan
from cnnsim.running_time import time_of_picture
from cnnsim.transient import Task

Cell = tuple[int, int]
"""(row, column), counted from 0 at the top left."""

_UNKNOWN = 10.0


@dataclass(frozen=True)
class Trace:
    """States ``x`` (frames, rows, cols) at the times ``t`` (frames,) [time constants], from 0 on."""

    t: NDArray[np.float64]
    x: NDArray[np.float64]

    @property
    def y(self) -> NDArray[np.float64]:
        """The outputs (frames, rows, cols)."""
        return output(self.x)


def record(task: Task, backend: Backend, duration: float, frames: int = 120) -> Trace:
    """Run a task for ``duration`` time constants and keep its state ``frames`` + 1 times; its stop rule is set aside.

    Raises:
        InputError: a duration that is not positive, fewer than one frame, or a batch of planes.
    """
    if not duration > 0 or frames < 1:
        raise InputError(f"a trace of {duration:g} time constants in {frames} frames; more than 0 and from 1 wanted")
    if task.state.ndim != 2:
        raise InputError(f"planes of shape {task.state.shape}; a trace is of one grid (rows, cols)")
    old = task.plan
    scheme = old.scheme.name if old.scheme is not None else None
    plan = make_plan(
        old.template, old.shape, old.boundary, duration=duration / frames, cell=old.cell,
        scheme="adaptive" if old.method == "adaptive" else scheme, step=old.step if scheme else None,
    )  # fmt: skip
    x: Any = task.state
    states = [np.array(x, dtype=np.float64)]
    for _ in range(frames):
        x = backend.read(task.start(backend, x, plan).x)
        states.append(np.array(x, dtype=np.float64))
    return Trace(np.linspace(0.0, duration, frames + 1), np.array(states))


def watching_time(task: Task, backend: Backend) -> float:
    """Return how long a transient is worth watching [time constants]: a little longer than its outputs change.

    The task's own duration if it has one; else the time at which it settles; of cells without neighbours, which are
    computed in closed form, their guaranteed time.
    """
    plan = task.plan
    if plan.duration != "settled":
        return float(plan.duration)
    if plan.method != "closed form":
        return max(1.0, task.start(backend).t)
    planes: dict[str, Any] = {"input": task.input, "bias": task.bias, "mask": task.mask}
    if not all(plane is None or isinstance(plane, np.ndarray) for plane in planes.values()):
        return _UNKNOWN  # planes that change with time
    known = time_of_picture(plan.template, state=task.state, boundary=plan.boundary, **planes)
    return _UNKNOWN if known.time is None else max(1.0, 1.2 * known.time)


def parse_cell(text: str, shape: tuple[int, ...]) -> Cell:
    """Read "row,col" as a cell of a grid; both count from 0.

    Raises:
        InputError: no two whole numbers, or a cell outside the grid.
    """
    try:
        row, col = (int(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"cell {text!r}; ROW,COL wanted, such as 3,4") from error
    if not (0 <= row < shape[0] and 0 <= col < shape[1]):
        raise InputError(f"cell {text} lies outside the grid: rows 0 to {shape[0] - 1}, columns 0 to {shape[1] - 1}")
    return row, col


def telling_cells(trace: Trace, most: int = 5) -> list[Cell]:
    """Return up to ``most`` cells whose states go different ways, in the order in which they first move.

    The first is the cell that moves most; each next one is that whose state is farthest from all those before it (sum
    of |x - x'| over time), until the rest only repeat what is there.
    """
    frames, _, cols = trace.x.shape
    states = trace.x.reshape(frames, -1)
    first = int(np.abs(np.diff(states, axis=0)).sum(axis=0).argmax())
    picked, apart = [first], np.full(states.shape[1], np.inf)
    while len(picked) < most:
        apart = np.minimum(apart, np.abs(states - states[:, picked[-1:]]).sum(axis=0))
        if apart.max() <= 0.02 * frames:
            break
        picked.append(int(apart.argmax()))
    final = np.abs(output(states) - output(states[-1])) < 0.5
    picked.sort(key=lambda cell: int(final[:, cell].argmax()))
    return [divmod(cell, cols) for cell in picked]
