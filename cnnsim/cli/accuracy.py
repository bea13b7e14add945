"""The command `accuracy`: what accuracy costs, for one template on one picture."""

import csv
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
import numpy as np

from cnnsim import backends, library
from cnnsim.cli.run import json_option
from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json, watched
from cnnsim.support.echo import say
from cnnsim.support.pictures.picture import read_picture

_FILE = click.Path(path_type=Path)


@click.command(
    epilog=examples(
        "cnnsim accuracy diffusion",
        "cnnsim accuracy hole-filler scan.png -o accuracy.png --time 10",
        "cnnsim accuracy diffusion photo.png --csv accuracy.csv --backend cpu --backend opencl",
    )
)
@click.argument("name")
@click.argument("picture", type=_FILE, required=False)
@click.option("-o", "--output", type=_FILE, help="Where the diagram goes (PNG, SVG, PDF).")
@click.option("--csv", "table", type=_FILE, help="Where the figures go, a line a run.")
@click.option("--time", "duration", type=float, help="Compare after so many time constants; else the template's or 10.")
@click.option("--backend", "names", multiple=True, type=click.Choice(backends.NAMES), help="One or more; cpu if none.")
@json_option
def accuracy(
    name: str, picture: Path | None, output: Path | None, table: Path | None, duration: float | None,
    names: tuple[str, ...], as_json: bool,
) -> None:  # fmt: skip
    """Measure what accuracy costs template NAME on PICTURE: every scheme, step and dtype against the exact transient.

    Without a picture a random one of 16 x 16 is taken; of a larger one its middle, 24 x 24, because the exact answer
    goes from kink to kink.
    """
    from cnnsim.prototyping.accuracy.work_precision import measured, reference_state, settings

    entry = library.load(name)
    shown = np.random.default_rng(1).uniform(-1, 1, (16, 16)) if picture is None else _middle(read_picture(picture))
    if entry.frame_time is not None or isinstance(entry.initial_state, tuple) or entry.cell.model == "discrete-time":
        raise InputError(f"template {name!r} takes a sequence, layers or discrete time; one layer that runs on wanted")
    given: dict[str, Any] = {"template": entry.network} | entry.task(
        shown, shown if entry.initial_state == "given" else None
    )
    given.pop("step", None)
    given.pop("accuracy", None)
    given.pop("limit", None)
    given["duration"] = duration or (10.0 if given["duration"] == "settled" else given["duration"])
    exact, how = reference_state(given)
    runs = list(settings(names or ("cpu",), 8))
    found = [measured(given, exact, setting) for setting in watched(runs, "runs", len(runs))]
    rows = [row for row in found if row is not None]
    if table is not None:
        with table.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(asdict(rows[0])))
            writer.writeheader()
            writer.writerows(asdict(row) for row in rows)
    if output is not None:
        from matplotlib.figure import Figure  # slow to import, and only needed for the diagram

        from cnnsim.prototyping.accuracy.plot import draw

        figure = Figure(figsize=(11, 4.5), layout="constrained")
        left, right = figure.subplots(1, 2)
        draw(rows, left, "evaluations", f"{name}, t = {given['duration']:g}")
        draw(rows, right, "seconds", f"{shown.shape[0]} x {shown.shape[1]} cells")
        right.legend(fontsize=7)
        figure.savefig(output, dpi=120)
    if as_json:
        print_json({"template": name, "reference": how, "rows": [asdict(row) for row in rows]})
        return
    say(f"{name}, {shown.shape[0]} x {shown.shape[1]} cells, t = {given['duration']:g}; truth: {how}")
    cheapest = [
        min((row for row in rows if row.error <= wanted), key=lambda row: row.seconds, default=None)
        for wanted in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
    ]
    first = next((row.seconds for row in cheapest if row is not None), 1.0)
    lines = [("error", "cheapest setting", "evaluations", "time", "times", "right signs")]
    for wanted, row in zip(range(1, 9), cheapest, strict=True):
        if row is None:
            lines.append((f"1e-{wanted}", "none of these", "", "", "", ""))
            continue
        setting = f"{row.scheme} h={row.step:.4g} {row.dtype} {row.backend}"
        lines.append((
            f"1e-{wanted}", setting, str(row.evaluations), f"{row.seconds * 1e3:.3g} ms", f"{row.seconds / first:.2g}",
            f"{row.signs:.2%}",
        ))  # fmt: skip
    widths = [max(len(line[column]) for line in lines) for column in range(6)]
    for line in lines:
        say("  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip())


def _middle(picture: Any, side: int = 24) -> Any:
    rows, cols = picture.shape[-2:]
    top, left = max(0, (rows - side) // 2), max(0, (cols - side) // 2)
    return picture[top : top + side, left : left + side]
