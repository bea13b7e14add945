"""Plot of a template: the entries of A and B as numbers on colours by sign and size."""

from typing import TYPE_CHECKING, Protocol

import numpy as np

from cnnsim.plot.figures import given_or_new
from cnnsim.support import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_NAME = 40
"""Characters of a name in a title."""
_LONG = 6
"""Characters of a number at the usual font size."""


class DrawnTemplate(Protocol):
    """The attributes of a template that are drawn."""

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

    @property
    def terms_words(self) -> str:
        """A text about its terms."""


def template(weights: DrawnTemplate, axes: "Axes | None" = None) -> "Axes":
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
        digits, size = _fitting(len(weights.A) + len(weights.B))
        numbers = {place: f"{value:.{digits}g}" for place, value in np.ndenumerate(matrix if digits else matrix[:0])}
        size *= min(1.0, _LONG / max(map(len, numbers.values()), default=1))
        for (i, j), number in numbers.items():
            axes.text(left + j + 0.5, top + i + 0.5, number, ha="center", va="center", fontsize=size)
        axes.text(left + side / 2, top - 0.02 * height, name, ha="center", va="bottom", fontsize=12)
        left += side + 0.6
    axes.set_xlim(-0.05, left - 0.55)
    axes.set_ylim(height + 0.05, -0.15 * height)
    axes.set_axis_off()
    name = weights.name if len(weights.name) <= _NAME else weights.name[: _NAME - 3] + "..."
    axes.set_title(f"{name}, z = {weights.z:g}{weights.terms_words}", fontsize=11)
    return axes


def _fitting(columns: int) -> tuple[int, float]:
    """Return digits and font size of the numbers in ``columns`` columns; (0, 0) if they do not fit."""
    return (4, 11) if columns <= 6 else (3, 6.5) if columns <= 10 else (2, 5.5) if columns <= 14 else (0, 0.0)
