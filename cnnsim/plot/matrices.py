"""Templates drawn: the entries of A and B as numbers on a colour that shows their sign and size."""

from typing import TYPE_CHECKING, Protocol

import numpy as np

from cnnsim.plot.figures import given_or_new
from cnnsim.support import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Weights(Protocol):
    """What is drawn of a template."""

    @property
    def A(self) -> Floats:  # noqa: N802 - the field's name
        """The feedback."""

    @property
    def B(self) -> Floats:  # noqa: N802 - the field's name
        """The control."""

    @property
    def z(self) -> float:
        """The bias."""

    @property
    def name(self) -> str:
        """Its name."""


def template(weights: Weights, axes: "Axes | None" = None) -> "Axes":
    """Draw the matrices A and B of a template side by side, positive entries red and negative ones blue."""
    axes = given_or_new(axes)
    most = max(float(np.abs(weights.A).max()), float(np.abs(weights.B).max()), 1e-300)
    left, height = 0.0, max(len(weights.A), len(weights.B))
    for name, matrix in (("A", weights.A), ("B", weights.B)):
        side = len(matrix)
        top = (height - side) / 2
        axes.imshow(
            matrix, cmap="RdBu_r", vmin=-1.6 * most, vmax=1.6 * most, extent=(left, left + side, top + side, top)
        )
        for (i, j), value in np.ndenumerate(matrix):
            size = 11 if side <= 3 else 7
            axes.text(left + j + 0.5, top + i + 0.5, f"{value:.4g}", ha="center", va="center", fontsize=size)
        axes.text(left + side / 2, -0.08, name, ha="center", va="bottom", fontsize=12)
        left += side + 0.6
    axes.set_xlim(-0.05, left - 0.55)
    axes.set_ylim(height + 0.05, -0.45)
    axes.set_axis_off()
    axes.set_title(f"{weights.name}, z = {weights.z:g}", fontsize=11)
    return axes
