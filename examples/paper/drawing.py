"""Helpers of the figures: panels of curves, and maps of lines with their located places."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from examples.paper.needle import NEAR
from examples.paper.skins import Trial


def figure(columns: int, rows: int = 1, size: tuple[float, float] = (4.4, 4.0)) -> tuple[Any, Any]:
    """Return a figure and its axes (rows, columns) of ``size`` [inch] each, drawn without a screen."""
    from matplotlib.figure import Figure  # slow to import

    drawn = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
    return drawn, drawn.subplots(rows, columns, squeeze=False)


def save(drawn: Any, path: Path, title: str = "") -> None:
    """Write a figure with a title above all panels."""
    drawn.suptitle(title)
    drawn.savefig(path, dpi=110)


def plot_curves(axes: Any, curves: Iterable[tuple[Any, Any, str, str, str | None]], **settings: Any) -> None:
    """Plot curves (x, y, style, colour, label) with a legend."""
    for x, y, style, colour, label in curves:
        axes.plot(x, y, style, color=colour, label=label, markersize=4)
    axes.set(**settings)
    axes.legend(fontsize=8)


def plot_map(axes: Any, trial: Trial, true: str, located: str, **settings: Any) -> None:
    """Plot the lines of a scan and the located ones [um] in these colours, and a circle of 150 um."""
    for places, found in zip(trial.made.places, trial.located.places, strict=True):
        axes.plot(*(places.T * 1e6), color=true, linewidth=1.6)
        axes.plot(*(found.T * 1e6), color=located, linewidth=0.7)
    turn = np.linspace(0, 2 * np.pi, 100)
    axes.plot(NEAR * 1e6 * np.cos(turn), NEAR * 1e6 * np.sin(turn), color="black", linewidth=0.7)
    axes.set(aspect="equal", xlim=(-330, 330), ylim=(330, -330), **settings)  # y increases downwards, like the rows
