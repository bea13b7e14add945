"""Plots of textures: windows over friction and roughness (Fig. 15 of the paper), and a confusion matrix."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support.files import make_folder, writing
from tactile.materials.assessment import Assessment
from tactile.materials.windows import WindowTable

HOW = {"block": "by block of slides", "slide": "by slide"}
POINTS = 3000
"""Largest number of windows drawn, as in the paper; a fixed random choice of more."""


def draw_figures(table: WindowTable, title: str, path: Path) -> None:
    """Write a plot of friction coefficient and roughness of windows, a colour for each material.

    ``table``: windows whose first two features are the logarithms of both.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure  # slow to import
    from matplotlib.ticker import LogLocator  # the same

    figure = Figure(figsize=(9, 6.5), layout="constrained")
    axis = figure.add_subplot()
    count = len(table.values)
    shown = np.sort(np.random.default_rng(0).permutation(count)[:POINTS])
    friction, roughness = np.exp(table.values[shown, :2]).T
    material = table.material[shown]
    names = sorted(set(material.tolist()), key=lambda one: (len(one), one))
    for name, (colour, marker) in zip(names, _styles(len(names)), strict=True):
        mine = material == name
        axis.scatter(friction[mine], roughness[mine], 14, color=[colour], marker=marker, alpha=0.7, linewidths=0,
                     label=name or "unknown")  # fmt: skip
    axis.set_xlabel("friction coefficient")
    axis.set_ylabel("roughness")
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.yaxis.set_minor_formatter(lambda *_: "")
    some = f"{len(shown)} of {count}" if len(shown) < count else f"{count}"
    axis.set_title(f"{title}: {some} windows", parse_math=False)
    axis.grid(alpha=0.3, which="both")
    figure.legend(loc="outside right upper", title="material", markerscale=1.6)
    _save(figure, path)


def draw_confusion(found: Assessment, title: str, path: Path) -> None:
    """Write a plot of predicted against true material, in percent of the windows of each.

    Raises:
        InputError: the file cannot be written.
    """
    from matplotlib.figure import Figure  # slow to import

    count = len(found.materials)
    side = max(5.0, 2.2 + 0.48 * count)
    figure = Figure(figsize=(side + 1, side), layout="constrained")
    axis = figure.add_subplot()
    rows = found.confusion.sum(axis=1, keepdims=True)
    percent = 100 * found.confusion / np.maximum(rows, 1)
    image = axis.imshow(percent, cmap="Blues", vmin=0, vmax=100)
    for (row, col), value in np.ndenumerate(percent):
        if found.confusion[row, col]:
            text = f"{value:.0f}" if value >= 1 else "<1"
            axis.text(col, row, text, ha="center", va="center", fontsize=8, color="white" if value > 55 else "black")
    axis.set_xticks(range(count), found.materials, rotation=0 if max(map(len, found.materials)) < 4 else 60)
    axis.set_yticks(range(count), found.materials)
    axis.set_xlabel("told")
    axis.set_ylabel("material")
    right = np.trace(found.confusion) / max(found.confusion.sum(), 1)
    axis.set_title(f"{title}: {right:.3f} right, tested {HOW[found.grouped]}", parse_math=False, fontsize=10)
    figure.colorbar(image, ax=axis, shrink=0.8, label="% of the material's windows")
    _save(figure, path)


def _styles(count: int) -> Sequence[tuple[Any, str]]:
    """Return colour and marker of each material, unique up to eighty."""
    from matplotlib import colormaps  # slow to import

    colours = colormaps["tab10" if count <= 10 else "tab20"].colors  # type: ignore[attr-defined]  # of listed maps
    return [(colours[n % len(colours)], "os^D"[n // len(colours) % 4]) for n in range(count)]


def _save(figure: Any, path: Path) -> None:
    make_folder(path.parent)
    with writing(path) as beside:
        figure.savefig(beside, dpi=100)
