"""The command `accuracy`: time and error of schemes and steps, for one template on one picture."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from cnnsim import backends, library
from cnnsim.cli.pictures import check_plot
from cnnsim.cli.run import json_option
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option, watched
from cnnsim.support.files import check_place, write_rows, writing
from cnnsim.support.pictures.read import read_picture
from cnnsim.support.terminal import echo, say

if TYPE_CHECKING:
    from cnnsim.prototyping.accuracy.work_precision import PrecisionRow

_FILE = click.Path(path_type=Path)


@click.command(
    epilog=examples(
        "cnnsim accuracy diffusion",
        "cnnsim accuracy hole-filler scan.png -o accuracy.png --csv accuracy.csv",
        "cnnsim accuracy diffusion photo.png --time 1 --backend cpu --backend reference",
    )
)
@click.argument("name")
@click.argument("picture", type=_FILE, required=False)
@click.option("-o", "--output", type=_FILE, help="Where the diagram goes (PNG, SVG, PDF).")
@click.option("--csv", "figures", type=_FILE, help="Where the figures go, a line a run.")
@click.option(
    "--time",
    "duration",
    type=float,
    help="Time constants after which runs are compared; the template's or 10 if not given.",
)
@click.option("--backend", "names", multiple=True, type=click.Choice(backends.NAMES), help="One or more; cpu if none.")
@replace_option
@json_option
def accuracy(
    name: str, picture: Path | None, output: Path | None, figures: Path | None, duration: float | None,
    names: tuple[str, ...], as_json: bool,
) -> None:  # fmt: skip
    """Measure time and error of schemes, steps and dtypes.

    Template NAME is run on PICTURE with each, and compared with the exact transient.

    Without a picture a random one of 16 x 16 is used; of a larger one its middle, 24 x 24.
    """
    from cnnsim.prototyping.functions import accuracy as measure_accuracy

    check_plot(output)
    check_place(figures)
    claim(output, figures)
    shown = np.random.default_rng(1).uniform(-1, 1, (16, 16)) if picture is None else _middle(read_picture(picture))
    found = measure_accuracy(
        library.load(name), shown, duration=duration, names=names or ("cpu",),
        track=lambda runs: watched(runs, "runs", len(runs)),
    )  # fmt: skip
    rows = list(found.rows)
    if figures is not None:
        write_rows(figures, [asdict(row) for row in rows])
    if output is not None:
        _draw(rows, output, found.title, f"{shown.shape[0]} x {shown.shape[1]} cells")
    if as_json:
        print_json({"template": name, "reference": found.reference, "rows": [asdict(row) for row in rows]})
        return
    say(f"{found.title}, {shown.shape[0]} x {shown.shape[1]} cells; exact state: {found.reference}")
    for line in table(rows):
        echo(line)


def table(rows: list["PrecisionRow"]) -> list[str]:
    """Return the lines of a table of the cheapest settings for 80 columns."""
    lines = _cheapest(rows)
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return ["  ".join(map(str.ljust, line, widths)).rstrip() for line in lines]


def _cheapest(rows: list["PrecisionRow"]) -> list[tuple[str, ...]]:
    """Return the rows of a table of the cheapest setting for each accuracy from 1e-1 to 1e-8, head first.

    Columns: evaluations of A*y, wall time, its ratio to the first row, share of correct signs.
    """
    lines: list[tuple[str, ...]] = [("error", "cheapest setting", "A*y", "time", "times", "signs")]
    first = None
    for wanted in (f"1e-{digits}" for digits in range(1, 9)):
        row = min((row for row in rows if row.error <= float(wanted)), key=lambda row: row.seconds, default=None)
        if row is None:
            lines.append((wanted, "none of these", "", "", "", ""))
            continue
        first = first or row.seconds
        setting = f"{row.scheme} h={row.step:.3g} {row.dtype} {row.backend}"
        cost = f"{row.seconds * 1e3:.3g} ms", f"{row.seconds / first:.2g}", f"{row.signs:.2%}"
        lines.append((wanted, setting, str(row.evaluations), *cost))
    return lines


def _draw(rows: list["PrecisionRow"], output: Path, title: str, size: str) -> None:
    from matplotlib.figure import Figure  # slow to import, and only needed for the diagram

    from cnnsim.prototyping.accuracy.plot import draw  # the same

    figure = Figure(figsize=(11, 4.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw(rows, left, "evaluations", title)
    draw(rows, right, "seconds", size)
    right.legend(fontsize=7)
    with writing(output) as temporary:
        figure.savefig(temporary, dpi=120)


def _middle(picture: Any, side: int = 24) -> Any:
    rows, cols = picture.shape[-2:]
    top, left = max(0, (rows - side) // 2), max(0, (cols - side) // 2)
    return picture[top : top + side, left : left + side]
