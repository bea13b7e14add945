"""Plots of states and outputs of cells over time."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from cnnsim.plot.figures import COLOURS, given_or_new
from cnnsim.support import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes


TURNS = ("-", ":", "-.")
"""Line styles: the next one is used when all colours are used."""


def states(t: Array, x: Array, labels: Sequence[str] = (), axes: "Axes | None" = None) -> "Axes":
    """Draw states ``x`` (times, cells) over the times ``t`` [time constants]; the range |x| <= 1 is grey."""
    axes = given_or_new(axes)
    axes.axhspan(-1, 1, color="#eeeeee", zorder=0)
    for cell in range(x.shape[1]):
        label = labels[cell] if labels else None
        style = TURNS[cell // len(COLOURS) % len(TURNS)]
        axes.plot(t, x[:, cell], color=COLOURS[cell % len(COLOURS)], linewidth=1.8, linestyle=style, label=label)
    axes.set_xlabel("time [time constants]")
    axes.set_ylabel("state x")
    axes.margins(x=0.01)
    return axes


def outputs(t: Array, y: Array, labels: Sequence[str] = (), axes: "Axes | None" = None) -> "Axes":
    """Draw outputs ``y`` (times, cells) over the times ``t`` [time constants]."""
    axes = given_or_new(axes)
    for cell in range(y.shape[1]):
        style: Any = (0, (4, 1 + cell % 3)) if cell % 2 else "-"  # outputs overlap at -1 and +1
        style = TURNS[cell // len(COLOURS) % len(TURNS)] if cell >= len(COLOURS) else style
        label = labels[cell] if labels else None
        axes.plot(t, y[:, cell], color=COLOURS[cell % len(COLOURS)], linewidth=1.8, linestyle=style, label=label)
    axes.set_ylim(-1.15, 1.15)
    axes.set_yticks([-1, 0, 1], ["-1", "0", "+1"])
    axes.set_xlabel("time [time constants]")
    axes.set_ylabel("output y\n(black: +1)")
    axes.margins(x=0.01)
    return axes
