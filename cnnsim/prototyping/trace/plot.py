"""Draws a trace: where the chosen cells lie, their states and outputs over time, and a sheet of pictures."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.prototyping.trace.trace import CellIndex, Trace
from cnnsim.support.files import writing

SHEET = 8
"""Pictures on the contact sheet."""

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8c564b")
"""Okabe and Ito's colours, which colour-blind readers tell apart, and a brown."""


def draw_trace(trace: Trace, cells: Sequence[CellIndex], title: str, path: str | Path) -> None:
    """Write the picture of a trace; the format follows the name's ending.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 7.0), layout="constrained")
    figure.suptitle(title, fontsize=13)
    parts: Any = figure.subfigures(2, 1, height_ratios=(2.9, 1.0))
    above, below = parts
    axes = above.subplot_mosaic([["map", "x"], ["map", "y"]], width_ratios=(1.0, 1.9), height_ratios=(1.5, 1.0))
    colours = {cell: _COLOURS[number % len(_COLOURS)] for number, cell in enumerate(cells)}
    _map(axes["map"], trace, colours)
    _states(axes["x"], trace, colours)
    _outputs(axes["y"], trace, colours)
    _sheet(below, trace)
    with writing(path) as beside:
        figure.savefig(beside, dpi=120)


def sheet_frames(trace: Trace) -> list[int]:
    """Return the frames of the contact sheet: evenly spaced while outputs change, first and last in."""
    moving = np.flatnonzero(np.abs(np.diff(trace.y, axis=0)).max(axis=(1, 2)) > 1e-3)
    last = int(moving[-1]) + 1 if moving.size else len(trace.t) - 1
    return [int(frame) for frame in np.unique(np.linspace(0, last, SHEET).round())]


def _map(axes: Any, trace: Trace, colours: dict[CellIndex, str]) -> None:
    from matplotlib.patches import Rectangle

    _picture(axes, trace.y[-1])
    axes.set_title("output at the end, and the cells", fontsize=10)
    for (row, col), colour in colours.items():
        axes.add_patch(Rectangle((col - 0.5, row - 0.5), 1, 1, fill=False, edgecolor="white", linewidth=4.5))
        axes.add_patch(Rectangle((col - 0.5, row - 0.5), 1, 1, fill=False, edgecolor=colour, linewidth=2.5))


def _states(axes: Any, trace: Trace, colours: dict[CellIndex, str]) -> None:
    axes.axhspan(-1, 1, color="#eeeeee", zorder=0)
    for (row, col), colour in colours.items():
        axes.plot(trace.t, trace.x[:, row, col], color=colour, linewidth=1.8, label=f"{row},{col}")
    axes.set_ylabel("state x")
    axes.set_title("grey: the linear piece |x| ≤ 1", fontsize=10)
    axes.tick_params(labelbottom=False)
    axes.margins(x=0.01)
    axes.legend(title="row,col", loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def _outputs(axes: Any, trace: Trace, colours: dict[CellIndex, str]) -> None:
    for number, ((row, col), colour) in enumerate(colours.items()):
        style = (0, (4, 1 + number % 3)) if number % 2 else "-"  # outputs lie on one another at -1 and +1
        axes.plot(trace.t, trace.y[:, row, col], color=colour, linewidth=1.8, linestyle=style)
    axes.set_ylim(-1.15, 1.15)
    axes.set_yticks([-1, 0, 1], ["-1", "0", "+1"])
    axes.set_xlabel("time [time constants]")
    axes.set_ylabel("output y\n(black: +1)")
    axes.margins(x=0.01)


def _sheet(figure: Any, trace: Trace) -> None:
    frames = sheet_frames(trace)
    row = figure.subplots(1, len(frames), squeeze=False)[0]
    for axes, frame in zip(row, frames, strict=True):
        _picture(axes, trace.y[frame])
        axes.set_title(f"t = {trace.t[frame]:.3g}", fontsize=10)


def _picture(axes: Any, plane: Any) -> None:
    axes.imshow(plane, cmap="gray_r", vmin=-1, vmax=1, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
