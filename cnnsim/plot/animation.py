"""Planes over time as an animation of matplotlib."""

from collections.abc import Sequence
from math import inf
from typing import TYPE_CHECKING, Any

from cnnsim.plot.figures import given_or_new
from cnnsim.plot.planes import plane, side_by_side
from cnnsim.support import Array, InputError

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes


def animation(
    t: Sequence[float] | Array, y: Sequence[Array] | Array, axes: "Axes | None" = None, *, interval: float = 50.0
) -> "FuncAnimation":
    """Return an animation of outputs ``y`` (times, rows, cols), the time ``t`` of each above it.

    ``interval`` is the time of a frame [ms]. In a notebook ``HTML(found.to_jshtml())`` plays it, and
    ``found.save("x.gif")`` writes it. Keep a reference while it runs: matplotlib does not.

    Raises:
        InputError: an interval that is not positive, or ``axes`` that are not Axes.
    """
    from matplotlib.animation import FuncAnimation  # slow to import, and only needed for plots

    if not 0 < interval < inf:
        raise InputError(f"interval {interval} ms; a positive number wanted")
    axes = plane(y[0], given_or_new(axes))
    image: Any = axes.images[-1]

    def draw(frame: int) -> tuple[Any]:
        image.set_data(side_by_side(y[frame]))
        axes.set_title(f"t = {t[frame]:.3g}", fontsize=10)
        return (image,)

    draw(0)
    whole: Any = axes.figure  # a subfigure's as well
    return FuncAnimation(whole, draw, frames=len(y), interval=interval, blit=False)
