"""Trajectory: states and outputs over time, of whole planes or of some cells, and how they are shown."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim.support import Array, Floats, InputError

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

CellIndex = tuple[int, int]
"""(row, column), counted from 0 at the top left."""

SHEET = 8
"""Pictures on the contact sheet."""


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """States ``x`` and outputs ``y`` at the times ``t`` (times,) [time constants].

    Of whole planes both are (times, rows, cols), of some ``cells`` (times, cells); layers and batches have their axes
    after the times.
    """

    t: Floats
    x: Array
    y: Array
    cells: tuple[CellIndex, ...] | None = None

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        of = " x ".join(map(str, self.x.shape[1:])) + " cells" if self.cells is None else f"cells {list(self.cells)}"
        span = f"t = {self.t[0]:g} to {self.t[-1]:g}" if len(self) else "none"
        return f"Trajectory({len(self)} times, {span}, {of}, {self.x.dtype})"

    def of_cell(self, row: int, col: int) -> Array:
        """Return the states of one cell over time.

        Raises:
            InputError: the cell was not recorded, or lies outside the grid.
        """
        if self.cells is not None:
            if (row, col) not in self.cells:
                raise InputError(f"cell ({row}, {col}) was not recorded; recorded are {list(self.cells)}")
            return self.x[..., self.cells.index((row, col))]
        rows, cols = self.x.shape[-2:]
        if not (0 <= row < rows and 0 <= col < cols):
            raise InputError(f"cell ({row}, {col}) lies outside the grid of {rows} x {cols}")
        return self.x[..., row, col]

    def plot(self, axes: "Axes | None" = None, *, cells: Sequence[CellIndex] | None = None) -> "Axes":
        """Draw the states of cells over time, or planes without ``cells`` as a row of pictures; return the axes.

        Arguments: ``axes`` of matplotlib, None for new ones; ``cells`` (row, column), of the recorded ones.

        Raises:
            InputError: a cell that was not recorded, cells of several layers or of a batch.
        """
        from cnnsim import plot

        chosen = self.cells if cells is None else tuple(cells)
        if chosen is None:
            shown = sheet_frames(self.y)
            return plot.sheet([self.y[k] for k in shown], [f"t = {self.t[k]:.3g}" for k in shown], axes)
        if not chosen:
            raise InputError("no cells; one (row, column) at least wanted")
        series = [self.of_cell(*cell) for cell in chosen]
        if series[0].ndim > 1:
            raise InputError(f"states of shape {series[0].shape} of one cell; a trajectory of a single grid wanted")
        axes = plot.states(self.t, np.array(series).T, [f"{row},{col}" for row, col in chosen], axes)
        axes.legend(title="row,col", fontsize=8)
        return axes

    def animate(self, axes: "Axes | None" = None, *, interval: float = 50.0) -> "FuncAnimation":
        """Return the outputs over time as an animation of matplotlib, ``interval`` [ms] a frame.

        Raises:
            InputError: only cells were recorded.
        """
        if self.cells is not None:
            raise InputError("an animation shows planes, and only cells were recorded; record times instead")
        from cnnsim import plot

        return plot.animation(self.t, self.y, axes, interval=interval)

    def _repr_png_(self) -> bytes:
        from cnnsim import plot

        if self.cells is not None and self.x.ndim == 2:
            return plot.to_png(self.plot, (6.5, 3.2))
        y = self.y if self.cells is None else self.y[..., None, :]  # cells of layers: a row of squares each
        shown = sheet_frames(y)
        titles = [f"t = {self.t[k]:.3g}" for k in shown]
        return plot.to_png(lambda axes: plot.sheet([y[k] for k in shown], titles, axes), (1.3 * len(shown), 1.6))

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import heading, image

        name, _, rest = repr(self).partition("(")
        return heading(name, rest.rstrip(")")) + image(self._repr_png_())


def sheet_frames(y: Any) -> list[int]:
    """Return the frames of the contact sheet: evenly spaced while outputs change, first and last in."""
    moving = np.flatnonzero(np.abs(np.diff(y, axis=0)).reshape(len(y) - 1, -1).max(axis=1, initial=0.0) > 1e-3)
    last = int(moving[-1]) + 1 if moving.size else len(y) - 1
    return [int(frame) for frame in np.unique(np.linspace(0, last, SHEET).round())]
