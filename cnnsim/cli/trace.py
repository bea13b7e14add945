"""The command `trace`: plots the transient of a template cell by cell."""

from pathlib import Path

import click
import numpy as np

from cnnsim import backends, library
from cnnsim.cli.pictures import (
    binary_option,
    check_film,
    check_plot,
    picture_argument,
    range_option,
    read_beside,
    read_for,
)
from cnnsim.cli.run import backend_option, json_option
from cnnsim.network.sides import RUN_BOUNDARY_FORMS, parse_run_boundary
from cnnsim.planning.scheme import ADAPTIVE, SCHEMES
from cnnsim.support import InputError
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option
from cnnsim.support.files import writing
from cnnsim.support.pictures.film import write_film
from cnnsim.support.pictures.sequence import PictureOptions
from cnnsim.support.terminal import say

_FILE = click.Path(path_type=Path)


@click.command(
    epilog=examples(
        "cnnsim trace edge square.png -o trace.png",
        "cnnsim trace hole-filler scan.png --binary --cell 3,4 --cell 5,5 -o holes.png --film film.gif",
        "cnnsim trace diffusion photo.png --time 5 --frames 50 -o states.npz",
        "cnnsim trace moving-parts frame1.png frame2.png frame3.png -o moving.png",
        "cnnsim trace recall mask.png --state marker.png --time 12 --scheme rk4 -o recall.png",
    )
)
@click.argument("name")
@picture_argument
@click.option(
    "-o",
    "--output",
    type=_FILE,
    help="Where the plot goes (PNG, SVG, PDF), or the states of all cells as numbers (.npz).",
)
@click.option("--cell", "cells", multiple=True, metavar="ROW,COL", help="A cell to follow; else representative ones.")
@click.option("--film", type=_FILE, help="Also write the output over time as a film (.gif, .mp4).")
@click.option("--frames", type=click.IntRange(1, 2000), default=120, show_default=True, help="Times that are kept.")
@click.option("--layer", type=click.IntRange(0), default=0, show_default=True, help="Of a network of layers.")
@click.option("--state", type=_FILE, help="The second picture, for templates that take one.")
@binary_option
@range_option
@click.option("--boundary", help=f"{RUN_BOUNDARY_FORMS} instead of the template's own.")
@click.option("--time", "duration", type=float, help="Watch this many time constants instead of until it settles.")
@click.option("--scheme", type=click.Choice([*SCHEMES, ADAPTIVE]), help="Integration scheme instead of the plan's.")
@backend_option
@replace_option
@json_option
def trace(
    name: str, pictures: tuple[Path, ...], output: Path | None, cells: tuple[str, ...], film: Path | None, frames: int,
    layer: int, state: Path | None, binary: bool, levels: tuple[float, float] | None, boundary: str | None,
    duration: float | None, scheme: str | None, backend: str, as_json: bool,
) -> None:  # fmt: skip
    """Plot states and outputs of cells over time.

    The transient of template NAME on PICTURE is recorded.

    Templates for moving pictures take several: files, a folder, a GIF, a video, .npy or .npz.
    """
    from cnnsim.prototyping.trace.trace import parse_cell_index, record, representative_cells, watching_time
    from cnnsim.task import make_task

    if output is None and film is None and not as_json:
        raise InputError("nothing to do: give -o for a plot, --film for a film, or --json")
    numbers = output is not None and output.suffix.lower() == ".npz"
    if not numbers:
        check_plot(output)
    check_film(film)
    claim(output, film)
    entry = library.load(name)
    where = backends.get(backend)
    reading = PictureOptions(binary, levels, where.dtype)
    shown = read_for(entry, pictures, reading, batch=False)
    given = entry.task(shown, read_beside(state, "--state", shown, reading))
    if boundary is not None:
        given["boundary"] = parse_run_boundary(boundary)
    chosen = [parse_cell_index(cell, given["state"].shape[-2:]) for cell in cells]
    if scheme is not None:
        given.pop("step", None)  # it was meant for another scheme
    if duration is not None:
        given["duration"] = duration
    elif scheme == ADAPTIVE:  # the adaptive scheme cannot look for rest; the plan's own one can
        given["duration"] = watching_time(make_task(entry.network, **given), where)
    task = make_task(entry.network, **given, scheme=scheme)
    found = record(task, where, watching_time(task, where) if duration is None else duration, frames, layer)
    chosen = chosen or representative_cells(found)
    if numbers and output is not None:
        with writing(output) as temporary:
            np.savez(temporary, t=found.t, x=found.x, y=found.y)
    elif output is not None:
        from cnnsim.prototyping.trace.plot import draw_trace

        draw_trace(found, chosen, f"{entry.name}: {entry.summary}", output, task, layer)
    if film is not None:
        write_film(list(found.y), film, times=found.t.tolist())
    if as_json:
        series = [{"cell": cell, "x": found.x[:, cell[0], cell[1]].tolist()} for cell in chosen]
        print_json({"template": name, "t": found.t.tolist(), "cells": series})
        return
    written = " ".join(str(path) for path in (output, film) if path is not None)
    text = " ".join(f"({row}, {col})" for row, col in chosen)
    say(f"{name}: {found.t[-1]:.4g} time constants, cells {text} -> {written}")
