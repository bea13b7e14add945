"""Result: the end of a transient, as text and as a picture."""

from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from cnnsim.planning.plan import Plan
from cnnsim.support import Array, Integers
from cnnsim.support.values import is_stored
from cnnsim.trajectories import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """The end of a transient: state ``x`` and output ``y`` (rows, cols), time ``t`` [time constants; inf: at rest].

    ``settled`` says whether nothing changes any more (see `Plan`); after a fixed duration that is not checked and it is
    False. ``rate`` is the largest |dx/dt| at the end, NaN if it was not computed. ``trajectory`` has what was recorded.
    ``distance`` bounds the distance of an output of a settled network from its rest, NaN of one that has not settled;
    ``how`` says how it is known. ``undecided`` (n, 2), or more columns for layers and batches, lists the cells whose
    output the smallest perturbation decides: with an accuracy all of them, else those on a separatrix at the end.
    ``error`` is the estimated largest error of a state where an accuracy was given, no less than the difference of the
    last two runs, else NaN.
    """

    x: Array
    t: float
    settled: bool
    rate: float
    plan: Plan
    trajectory: Trajectory | None = None
    distance: float = nan
    undecided: Integers = field(default_factory=lambda: np.empty((0, 2), np.int64))
    how: str = ""
    error: float = nan

    @property
    def y(self) -> Array:
        """The output: clip(x, -1, 1), or what the cell's characteristic makes of the state."""
        return self.plan.output(self.x)

    def __repr__(self) -> str:
        recorded = "" if self.trajectory is None else f", {self.trajectory!r}"
        return f"Result({self._words()}{recorded})"

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the output into axes of matplotlib, or new ones, and return them; layers lie side by side, numbered."""
        from cnnsim import plot

        axes = plot.plane(self.y, axes, title=f"{self.plan.template.name}, {self._ended()}")
        layers = self.plan.network is not None and len(self.plan.network.layers) > 1
        axes.set_xlabel(", ".join(["picture"] * (self.y.ndim - layers > 2) + ["layer"] * layers))
        return axes

    def _ended(self) -> str:
        if not np.isfinite(self.t):
            return "at rest"
        return f"t = {self.t:g}" + (", settled" if self.settled else "")

    def _words(self) -> str:
        size = " x ".join(map(str, self.x.shape))
        rate = "" if np.isnan(self.rate) or not np.isfinite(self.t) else f", rate {self.rate:.3g}"
        away = "" if not self.distance > 0 else f", within {self.distance:.2g} of its end"
        away += "" if np.isnan(self.error) else f", error {self.error:.2g}"
        away += f", {len(self.undecided)} undecided" if len(self.undecided) else ""
        words = f"{self.plan.template.name!r}, {self._ended()}{rate}{away}, {size} {self.x.dtype}"
        if is_stored(self.x):  # it may be larger than the memory
            return f"{words}, on the disk"
        return f"{words}, x {self.x.min():.3g} to {self.x.max():.3g}, {int((self.y > 0).sum())} black"

    def _repr_png_(self) -> bytes:
        from cnnsim.support.pictures.picture import to_png

        return to_png(self.y)

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import heading, image

        shown = "" if self.trajectory is None else self.trajectory._repr_html_()
        picture = "" if is_stored(self.x) else image(self._repr_png_())
        return heading("Result", self._words()) + picture + shown
