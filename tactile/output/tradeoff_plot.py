"""Diagram of effects chosen for several tolerances: error against time, on logarithmic axes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Point(Protocol):
    """A choice of effects, see `tactile.simulator.tradeoff.Trade`."""

    @property
    def tolerance(self) -> float: ...  # noqa: D102 - 0 for all effects
    @property
    def error(self) -> float: ...  # noqa: D102 - found
    @property
    def bound(self) -> float: ...  # noqa: D102 - promised
    @property
    def seconds(self) -> float: ...  # noqa: D102 - a frame


def draw_trades(rows: Sequence[Point], axes: "Axes", title: str) -> None:
    """Draw the error found, its bound and the tolerance against the time of a frame; all effects are a line."""
    from matplotlib.ticker import LogLocator  # slow to import, and only needed for plots

    time = [row.seconds * 1e6 for row in rows[1:]]
    axes.axvline(rows[0].seconds * 1e6, color="black", linewidth=1, linestyle=":", label="all effects on")
    axes.plot(time, [row.tolerance for row in rows[1:]], "_", color="black", markersize=14, label="asked for")
    axes.plot(time, [row.bound for row in rows[1:]], "^", fillstyle="none", color="C1", zorder=3, label="bound")
    axes.plot(time, [row.error for row in rows[1:]], "o", color="C0", label="error found, where not 0")
    axes.set(xscale="log", yscale="log", title=title)
    axes.set(xlabel="processor time of a frame of one finger [us]", ylabel="largest error over the peak")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))  # less than a decade, often: powers of ten would be none
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3, which="both")
