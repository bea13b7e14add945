"""Plots of a sweep: any column against any other, a colour for each value of a third."""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cnnsim.plot.figures import COLOURS
from cnnsim.support import InputError
from cnnsim.support.files import writing
from cnnsim.sweep.kind import Row

MOST_COLOURS = 8


def parse_plot(text: str) -> tuple[str, str, str | None]:
    """Read "X,Y" or "X,Y,COLOUR" as names of columns.

    Raises:
        InputError: another number of them.
    """
    names = [name.strip() for name in text.split(",")]
    if len(names) not in (2, 3) or not all(names):
        raise InputError(f"plot {text!r}; X,Y or X,Y,COLOUR, columns of the table, wanted")
    return names[0], names[1], names[2] if len(names) == 3 else None


def draw_columns(rows: Sequence[Row], x: str, y: str, colour: str | None, path: Path, keys: Sequence[str] = ()) -> None:
    """Draw column ``y`` against ``x``: a dot for each case, a line through the means of equal x; without failed cases.

    The title names the ``keys`` over whose values a mean is.

    Raises:
        InputError: no such column, or one without a value; a colour with more than `MOST_COLOURS` values.
    """
    for name in (x, y, colour):
        if name is not None and (not rows or name not in rows[0]):
            raise InputError(f"no column {name!r} in the table; {', '.join(rows[0] if rows else [])} are there")
    points: dict[Any, list[tuple[Any, Any]]] = defaultdict(list)
    for row in rows:
        if row[x] is not None and row[y] is not None and row.get("error") is None:
            points[row[colour] if colour else None].append((row[x], row[y]))
    if not points:
        raise InputError(f"no case has both {x} and {y}; nothing to plot")
    if len(points) > MOST_COLOURS:
        raise InputError(f"{colour} has {len(points)} values; a column of at most {MOST_COLOURS} wanted for colours")
    from matplotlib.figure import Figure  # slow to import, and only needed for plots

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for number, (value, pairs) in enumerate(sorted(points.items(), key=lambda item: str(item[0]))):
        of_x: dict[Any, list[Any]] = defaultdict(list)
        for at, height in pairs:
            of_x[at].append(height)
        tint = COLOURS[number % len(COLOURS)]
        axes.plot(*zip(*pairs, strict=True), ".", color=tint, alpha=0.35, markersize=4)
        if not isinstance(pairs[0][1], str):
            places = sorted(of_x)
            means = [sum(of_x[at]) / len(of_x[at]) for at in places]
            axes.plot(places, means, "-o", color=tint, markersize=3, label=None if colour is None else str(value))
    axes.set(xlabel=x, ylabel=y, title=f"mean over {', '.join(keys)}" if keys else "")
    axes.grid(alpha=0.3)
    if colour is not None:
        axes.legend(title=colour, fontsize=8)
    with writing(path) as temporary:
        figure.savefig(temporary, dpi=120)
