"""Plots of planes: black is +1, white is -1, a cell is a square."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.plot.figures import COLOURS, given_or_new
from cnnsim.support import Array, InputError
from cnnsim.support.values import as_numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plane(values: ArrayLike, axes: "Axes | None" = None, *, title: str = "") -> "Axes":
    """Draw CNN values (rows, cols) and return the axes; values outside [-1, 1] are clipped, True is black.

    Planes (n, rows, cols), of layers or of a batch, are side by side with their numbers.

    Raises:
        InputError: another shape, or whole numbers as of grey levels.
    """
    planes = as_numbers("plane", values)
    picture, axes = side_by_side(planes), given_or_new(axes)
    axes.imshow(picture, cmap="gray_r", vmin=-1, vmax=1, interpolation="nearest")
    cols, several = planes.shape[-1], [", ".join(map(str, at)) for at in np.ndindex(planes.shape[:-2])]
    middles = [(number + 0.5) * cols - 0.5 for number in range(len(several))] if len(several) > 1 else []
    axes.set_xticks(middles, several[: len(middles)], fontsize=9)
    axes.tick_params(length=0)
    for edge in range(1, len(middles)):
        axes.axvline(edge * cols - 0.5, color=COLOURS[0], linewidth=0.8)
    axes.set_yticks([])
    axes.set_title(title, fontsize=10)
    return axes


def sheet(planes: Sequence[Array], titles: Sequence[str], axes: "Axes | None" = None) -> "Axes":
    """Draw planes of one shape side by side with their titles.

    A plane is (rows, cols), or (layers, rows, cols), whose layers are side by side with their numbers.
    """
    pictures, axes = [side_by_side(values) for values in planes], given_or_new(axes)
    rows, cols = pictures[0].shape
    several = list(np.ndindex(planes[0].shape[:-2])) if planes[0].ndim > 2 else []
    gap = max(1.0, 0.08 * cols)
    for number, (picture, title) in enumerate(zip(pictures, titles, strict=True)):
        left = number * (cols + gap)
        axes.imshow(picture, cmap="gray_r", vmin=-1, vmax=1, interpolation="nearest",
                    extent=(left, left + cols, rows, 0))  # fmt: skip
        axes.plot([left, left + cols, left + cols, left, left], [0, 0, rows, rows, 0], color="black", linewidth=0.8)
        axes.text(left + cols / 2, -0.03 * rows, title, ha="center", va="bottom", fontsize=9)
        for place, index in enumerate(several):
            x0, wide = left + place * cols / len(several), cols / len(several)
            axes.text(x0 + wide / 2, 1.03 * rows, ", ".join(map(str, index)), ha="center", va="top", fontsize=8)
            axes.plot([x0, x0], [0, rows], color=COLOURS[0] if place else "black", linewidth=0.8)
    axes.set_xlim(-0.02 * cols, len(pictures) * (cols + gap) - gap + 0.02 * cols)
    axes.set_ylim(1.02 * rows, -0.02 * rows)
    axes.set_axis_off()
    return axes


def side_by_side(values: Array) -> Array:
    """Return planes (..., rows, cols) side by side as one plane.

    Raises:
        InputError: fewer than two axes.
    """
    if values.ndim < 2:
        raise InputError(f"a plane of shape {values.shape}; (rows, cols) or (n, rows, cols) wanted")
    return np.concatenate(list(values.reshape(-1, *values.shape[-2:])), axis=1)
