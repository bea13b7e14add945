"""Figure of a trace: given planes, the chosen cells, states and outputs over time, and a row of pictures."""

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from cnnsim import plot
from cnnsim.network import Frames
from cnnsim.network.frames import at_step
from cnnsim.plot.figures import COLOURS
from cnnsim.support import Array
from cnnsim.support.files import writing
from cnnsim.task import Task
from cnnsim.trajectories import CellIndex, Trajectory, sheet_frames

Pictures = list[tuple[str, Array]]


def draw_trace(
    trace: Trajectory, cells: Sequence[CellIndex], title: str, path: str | Path, task: Task, layer: int = 0
) -> None:
    """Write the picture of a trace of a ``task``, whose input and initial state are drawn too.

    The format follows the name's ending.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    shown = sheet_frames(trace.y)
    rows = [("output y", [trace.y[frame] for frame in shown])]
    if isinstance(task.input, Frames):
        rows.insert(0, ("input u", [_held(task, float(trace.t[frame]), layer) for frame in shown]))
    figure = Figure(figsize=(11, 7.3 + 1.5 * (len(rows) - 1)), layout="constrained")
    title += f" Layer {layer} of 0 to {len(task.state) - 1}." if task.state.ndim == 3 else ""
    figure.suptitle("\n".join(wrap(title, 95)), fontsize=13)
    parts: Any = figure.subfigures(2, 1, height_ratios=(2.9, 0.8 * len(rows)))
    above, below = parts
    axes = above.subplot_mosaic([["given", "x"], ["map", "y"]], width_ratios=(1.0, 1.9), height_ratios=(1.0, 1.0))
    _given(axes["given"], given_pictures(task, layer))
    _map(axes["map"], trace, cells)
    labels = [f"{row},{col}" for row, col in cells]
    plot.states(trace.t, _series(trace.x, cells), labels, axes["x"])
    axes["x"].set_xlabel("")
    axes["x"].set_title("grey: the linear piece |x| ≤ 1", fontsize=10)
    axes["x"].tick_params(labelbottom=False)
    axes["x"].legend(title="row,col", loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    plot.outputs(trace.t, _series(trace.y, cells), (), axes["y"])
    _sheet(below, rows, [float(trace.t[frame]) for frame in shown])
    with writing(path) as temporary:
        figure.savefig(temporary, dpi=120)


def given_pictures(task: Task, layer: int = 0) -> Pictures:
    """Return what a run starts from, each with its name: the input and the initial state, one where they are the same.

    A plane that is the same everywhere is no picture, unless nothing else is given.
    """
    state = _layer(task.state, layer)
    if not task.plan.template.reads_input and task.plan.network is None:
        return [("initial state x(0)", state)]
    frames = task.input.planes if isinstance(task.input, Frames) else None
    first = frames[0] if frames is not None else task.input
    found: Pictures = []
    if first is not None:
        name = "input u" if frames is None else f"input u, the first of {len(frames)}"
        found.append((name, _layer(np.asarray(first), layer)))
        if np.array_equal(found[0][1], state):
            return [(f"{name} = x(0)", state)]
    if not found or state.min() < state.max():
        found.append(("initial state x(0)", state))
    return found


def _layer(planes: Array, layer: int) -> Array:
    return planes[layer] if planes.ndim == 3 else planes


def _held(task: Task, t: float, layer: int) -> Array:
    """Return the input at a time; at the end of the run the last one."""
    step = task.plan.step
    return _layer(np.asarray(at_step(task.input, max(0, round(t / step) - 1), step)), layer)


def _series(planes: Array, cells: Sequence[CellIndex]) -> Array:
    return np.array([planes[:, row, col] for row, col in cells]).T


def _given(axes: Any, pictures: Pictures) -> None:
    if len(pictures) == 1:
        plot.plane(pictures[0][1], axes, title=pictures[0][0])
    else:
        plot.sheet([values for _, values in pictures], [name for name, _ in pictures], axes)


def _map(axes: Any, trace: Trajectory, cells: Sequence[CellIndex]) -> None:
    from matplotlib.patches import Rectangle

    plot.plane(trace.y[-1], axes, title="output at the end, and the cells")
    for number, (row, col) in enumerate(cells):
        colour = COLOURS[number % len(COLOURS)]
        for edge, width in (("white", 4.5), (colour, 2.5)):  # cells of the rim are marked whole, beyond the axes
            square = Rectangle((col - 0.43, row - 0.43), 0.86, 0.86, fill=False, edgecolor=edge, linewidth=width)
            axes.add_patch(square).set(clip_on=False, zorder=3)


def _sheet(figure: Any, rows: list[tuple[str, list[Array]]], times: Sequence[float]) -> None:
    grid = figure.subplots(len(rows), len(times), squeeze=False)
    for number, (name, pictures) in enumerate(rows):
        for axes, picture, t in zip(grid[number], pictures, times, strict=True):
            plot.plane(picture, axes, title=f"t = {t:.3g}" if number == 0 else "")
        grid[number][0].set_ylabel(name, fontsize=10)
