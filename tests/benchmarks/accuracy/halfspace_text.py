"""The words, table and diagrams of section 2: sums, areas, contacts, circles, layers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tests.benchmarks.accuracy.rounds import first_below

BY_ACCURACY = "by accuracy"
"""The way of the rows about the accuracy of a scene."""


def worst_sum(rows: list[dict[str, Any]]) -> float:
    """The largest error of the ways to sum in float64."""
    return max(row["error"] for row in rows if row["family"] == "sums" and "float32" not in row["way"])


def costs(rows: list[dict[str, Any]], family: str, way: str) -> dict[float, float]:
    """The smallest size that reaches 1e-3 and 1e-6."""
    found = [(row["size"], row["error"]) for row in rows if row["family"] == family and row["way"].startswith(way)]
    return {wanted: first_below(found, wanted) for wanted in (1e-3, 1e-6)}


_TEXT = """\
**Ways to sum.** Random tractions on the taxels' own grid, n x n loads on n x n taxels, against the formula in 80
bits. The direct sum and the transforms agree to rounding; the scene takes the fastest and says
which (`tactile explain`). float32, tried in the same formula in NumPy, keeps six digits and takes {single:.2g} x the
time of float64 there (median); a scene takes float64 unless it asks for less.

| loads x taxels | {ways} |
{table}

**Points of a taxel's area.** Gauss points converge geometrically, faster the deeper the taxel. The effect
`taxel_area` takes as many as the scene's accuracy asks for.

**Contacts.** Cells that carry Hertz' pressure converge with the square of their number a side at best, because the
pressure has a vertical slope at the rim; squares are no better than points once cells are smaller than the depth. A
circle in closed form is exact and costs {circle:.2g} x what {cells} cells a side cost, the fewest that reach 1e-3.

**Circles by accuracy.** A disc and a sphere with friction 0.6 that move over 8 x 8 taxels, sheared: circles come from
tables as fine as the accuracy of the scene asks for (1e-4 of the peak unless it says), and are the finest there are at
0. Time of a frame, how many times faster than the finest that is, and the error found:

| contact and cover | {accuracies} |
{circles}

**Layer.** What a bonded layer adds is an integral over waves that fall off exponentially: {waves:g} Gauss points
reach 1e-6. The product keeps it as a table over the distance, made once for a depth, a Poisson's ratio and a
quantity: error {spline:.0e} of the peak."""


def text(rows: list[dict[str, Any]], sums: Sequence[int]) -> str:
    """The paragraphs of the section; ``sums``: sides of the grids that are summed."""
    ways = ("direct", "transforms", "NumPy, float64", "NumPy, float32")
    lines = ["|---" * (len(ways) + 1) + "|"]
    for side in sums:
        cells = []
        for way in ways:
            found = [row for row in rows if (row["family"], row["way"], row["size"]) == ("sums", way, side)]
            cells.append(f"{found[0]['seconds'] * 1e3:.3g} ms, {found[0]['error']:.0e}" if found else "too large")
        lines.append(f"| {side}² x {side}² | " + " | ".join(cells) + " |")
    disc = [row for row in rows if row["family"].startswith("Hertz")]
    enough = costs(rows, "Hertz contact, a = z", "cells a side, as points")[1e-3]
    reached = [row["seconds"] for row in disc if row["way"].endswith("as points") and row["size"] == enough]
    layer = [row for row in rows if row["family"].startswith("layer")]
    circles = [row for row in rows if row["way"] == BY_ACCURACY]
    one = len({row["size"] for row in circles})
    starts = range(0, len(circles), one)
    time = {(row["way"], row["size"]): row["seconds"] for row in rows if row["family"] == "sums"}
    single = float(np.median([time["NumPy, float32", n] / time["NumPy, float64", n] for n in sums]))
    return _TEXT.format(
        single=single,
        accuracies=" | ".join(f"{r['size']:g}" if r["size"] else "finest" for r in circles[:one]),
        circles="\n".join(["|---" * (one + 1) + "|", *(_by_accuracy(circles[k : k + one]) for k in starts)]),
        ways=" | ".join(ways), table="\n".join(lines), cells=f"{enough:g}", circle=disc[-1]["seconds"] / reached[0],
        waves=costs(rows, "layer of 2 z", "Gauss")[1e-6], spline=layer[-1]["error"],
    )  # fmt: skip


def _by_accuracy(rows: list[dict[str, Any]]) -> str:
    """A contact's line of the table, the finest first."""
    finest, *others = rows
    slow = finest["seconds"]
    cells = [
        f"{row['seconds'] * 1e6:.3g} us, {slow / row['seconds']:.3g} x faster, {row['error']:.0e}" for row in others
    ]
    return f"| {finest['family']} | {slow * 1e6:.3g} us | " + " | ".join(cells) + " |"


def draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    """Error against time, a diagram each."""
    axes = figure.subplots(2, 2)
    (sums, area), (disc, layer) = axes
    families = list(dict.fromkeys(row["family"] for row in rows))
    for one, start, title in (
        (sums, "sums", "ways to sum n² loads on n² taxels"),
        (area, "taxel area", "points of a taxel's area"),
        (disc, "Hertz", "a contact in cells"),
        (layer, "layer", "a layer of 2 z"),
    ):
        for family in (name for name in families if name.startswith(start)):
            for way in dict.fromkeys(row["way"] for row in rows if row["family"] == family):
                found = [row for row in rows if (row["family"], row["way"]) == (family, way)]
                _line(one, found, family if start == "taxel area" else way)
        one.set(title=title, ylabel="largest error over the peak")
    for one in axes.ravel():
        one.set_xlabel("best wall time [s]")
        one.legend(fontsize=8)
        one.grid(alpha=0.3)


def _line(axes: Any, found: list[dict[str, Any]], label: str) -> None:
    at = [(row["seconds"], max(row["error"], 1e-17)) for row in found]
    many = len(found) > 1
    axes.loglog(*zip(*at, strict=True), "o-" if many else "*", markersize=4 if many else 12, label=label)
    for row, where in zip(found if many else (), at, strict=False):
        axes.annotate(f"{row['size']:g}", where, fontsize=7, xytext=(3, 3), textcoords="offset points")
