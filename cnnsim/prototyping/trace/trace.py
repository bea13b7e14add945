"""Trace of a transient: the states of a plane at evenly spaced times, and cells that represent it."""

from typing import Any

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.support import InputError
from cnnsim.task import Task
from cnnsim.theory.running_time import time_of_picture
from cnnsim.trajectories import CellIndex, Trajectory

_UNKNOWN = 10.0


def record(task: Task, backend: Backend, duration: float, frames: int = 120, layer: int = 0) -> Trajectory:
    """Run a task for ``duration`` time constants and keep its state ``frames`` + 1 times; its stop rule is set aside.

    Of a network of layers one ``layer`` is kept, counted from 0.

    Raises:
        InputError: a duration that is not positive, fewer than one frame, a layer that is not there, a batch of planes.
    """
    if not 0 < duration < np.inf or frames < 1:
        raise InputError(f"a trace of {duration:g} time constants in {frames} frames; more than 0 and from 1 wanted")
    layers = task.state.shape[0] if task.state.ndim == 3 else 1
    if task.state.ndim > 2 and (task.plan.network is None or len(task.plan.network.layers) != layers):
        raise InputError(f"planes of shape {task.state.shape}; a trace is of one grid, not of a batch")
    if not 0 <= layer < layers:
        raise InputError(f"layer {layer}; 0 to {layers - 1} wanted")
    later = task.states(backend, duration, frames, first=1)
    times, states = zip((0.0, task.state), *later, strict=True)
    x = np.array([state.reshape(-1, *state.shape[-2:])[layer] for state in states], dtype=np.float64)
    return Trajectory(np.array(times), x, task.plan.output(x))


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


def parse_cell_index(text: str, shape: tuple[int, ...]) -> CellIndex:
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


def representative_cells(trace: Trajectory, most: int = 5) -> list[CellIndex]:
    """Return up to ``most`` cells whose states go different ways, in the order in which they first move.

    The first is the cell that moves most; each next one is that whose state is farthest from all those before it (sum
    of |x - x'| over time), until the others repeat these.
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
    outputs = trace.y.reshape(frames, -1)
    final = np.abs(outputs - outputs[-1]) < 0.5
    picked.sort(key=lambda cell: int(final[:, cell].argmax()))
    return [divmod(cell, cols) for cell in picked]
