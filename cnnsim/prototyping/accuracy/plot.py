"""Work-precision diagrams: error against evaluations and against time, on logarithmic axes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from cnnsim.plot.figures import COLOURS
from cnnsim.prototyping.accuracy.work_precision import PrecisionRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARKS = {"float32": ("o", "none"), "float64": ("s", "full")}


def draw(rows: Sequence[PrecisionRow], axes: "Axes", against: str, title: str) -> None:
    """Draw the largest error against "evaluations" or "seconds" into axes: a line a scheme, dtype and backend."""
    lines = sorted({(row.backend, row.scheme, row.dtype) for row in rows})
    schemes = sorted({row.scheme for row in rows})
    for backend, scheme, dtype in lines:
        runs = [row for row in rows if (row.backend, row.scheme, row.dtype) == (backend, scheme, dtype)]
        runs.sort(key=lambda row: -row.step)
        points = [(getattr(row, against), max(row.error, 1e-15)) for row in runs]
        marker, fill = _MARKS[dtype]
        axes.loglog(
            *zip(*points, strict=True), marker=marker, fillstyle=fill, markersize=4, linewidth=1,
            linestyle={"cpu": "-", "opencl": "--"}.get(backend, ":"), color=COLOURS[schemes.index(scheme)],
            label=f"{scheme}, {dtype}" + ("" if backend == "cpu" else f", {backend}"),
        )  # fmt: skip
    axes.set(xlabel="evaluations of A*y" if against == "evaluations" else "best wall time [s]", title=title)
    axes.set(ylabel="largest error of a state")
    axes.grid(alpha=0.3)
