"""New axes of matplotlib, and figures as PNG."""

from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any

from cnnsim.support import InputError
from cnnsim.support.errors import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8c564b")
"""Okabe and Ito's colours, which colour-blind readers can distinguish, and a brown."""


def given_or_new(axes: "Axes | None") -> "Axes":
    """Return the axes, or new ones of a pyplot figure, which notebooks and ``plt.show()`` show.

    Raises:
        InputError: ``axes`` are not Axes, such as a figure.
    """
    if axes is not None:
        if not hasattr(axes, "imshow"):
            raise InputError(f"axes {shown(axes)}; Axes of matplotlib wanted, as of pyplot.subplots()[1]")
        return axes
    from matplotlib import pyplot  # slow to import, and only needed for plots

    return pyplot.subplots(layout="constrained")[1]


def to_png(draw: "Callable[[Axes], Any]", size: tuple[float, float] = (6.0, 4.0), dpi: int = 100) -> bytes:
    """Return what ``draw`` draws into new axes as a PNG file of ``size`` [inch], without pyplot."""
    from matplotlib.figure import Figure  # slow to import, and only needed for plots

    figure, file = Figure(figsize=size, layout="constrained"), BytesIO()
    draw(figure.add_subplot())
    figure.savefig(file, format="png", dpi=dpi)
    return file.getvalue()
