"""The commands for prototyping templates: trace, robust, design."""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from cnnsim import backends, library
from cnnsim.cli.run import read_frames
from cnnsim.network.boundary import BOUNDARY_FORMS, parse_boundary
from cnnsim.planning.scheme import ADAPTIVE, SCHEMES
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.errors import InputError
from cnnsim.support.picture import read_picture, write_film

_backend = click.option("--backend", type=click.Choice(backends.NAMES), default="cpu", show_default=True)
_json = click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
_FILE = click.Path(path_type=Path)


@click.command(
    epilog=examples(
        "cnnsim trace edge square.png -o trace.png",
        "cnnsim trace hole-filler scan.png --binary --cell 3,4 --cell 5,5 -o trace.png --film film.gif",
        "cnnsim trace moving-parts frame1.png frame2.png frame3.png -o trace.png",
        "cnnsim trace recall mask.png --state marker.png --time 12 --scheme rk4 -o trace.png",
    )
)
@click.argument("name")
@click.argument("pictures", type=_FILE, nargs=-1, required=True, metavar="PICTURE...")
@click.option("-o", "--output", type=_FILE, help="Where the plot goes (PNG, SVG, PDF).")
@click.option("--cell", "cells", multiple=True, metavar="ROW,COL", help="A cell to follow; some telling ones if none.")
@click.option("--film", type=_FILE, help="Also write the output over time as a GIF.")
@click.option("--frames", type=click.IntRange(1, 2000), default=120, show_default=True, help="Times at which to look.")
@click.option("--layer", type=click.IntRange(0), default=0, show_default=True, help="Of a network of layers.")
@click.option("--state", type=_FILE, help="The second picture, for templates that take one.")
@click.option("--binary", is_flag=True, help="Make the pictures black and white before the run.")
@click.option("--boundary", help=f"{BOUNDARY_FORMS} instead of the template's own.")
@click.option("--time", "duration", type=float, help="Watch this many time constants instead of until it settles.")
@click.option("--scheme", type=click.Choice([*SCHEMES, ADAPTIVE]), help="Integration scheme instead of the plan's.")
@_backend
@_json
def trace(
    name: str, pictures: tuple[Path, ...], output: Path | None, cells: tuple[str, ...], film: Path | None, frames: int,
    layer: int, state: Path | None, binary: bool, boundary: str | None, duration: float | None, scheme: str | None,
    backend: str, as_json: bool,
) -> None:  # fmt: skip
    """Record the transient of template NAME on PICTURE: states and outputs over time, and the pictures.

    Templates for moving pictures take several, one a frame.
    """
    from cnnsim.prototyping.trace.trace import parse_cell_index, record, representative_cells, watching_time
    from cnnsim.transient import make_task

    if output is None and film is None and not as_json:
        raise InputError("nothing to do: give -o for a plot, --film for a film, or --json")
    entry = library.load(name)
    second = None if state is None else read_picture(state, binary=binary)
    given = entry.task(read_frames(entry, pictures, binary=binary), second)
    if boundary is not None:
        given["boundary"] = parse_boundary(boundary)
    chosen = [parse_cell_index(cell, given["state"].shape[-2:]) for cell in cells]
    where = backends.get(backend)
    if scheme is not None:
        given.pop("step", None)  # it was meant for another scheme
    if duration is not None:
        given["duration"] = duration
    elif scheme == ADAPTIVE:  # the adaptive scheme cannot look for rest; the plan's own one can
        given["duration"] = watching_time(make_task(entry.network, **given), where)
    task = make_task(entry.network, **given, scheme=scheme)
    found = record(task, where, watching_time(task, where) if duration is None else duration, frames, layer)
    chosen = chosen or representative_cells(found)
    if output is not None:
        from cnnsim.prototyping.trace.plot import draw_trace

        draw_trace(found, chosen, f"{entry.name}: {entry.summary}", output)
    if film is not None:
        write_film(list(found.y), film)
    if as_json:
        series = [{"cell": cell, "x": found.x[:, cell[0], cell[1]].tolist()} for cell in chosen]
        print_json({"template": name, "t": found.t.tolist(), "cells": series})
        return
    written = " ".join(str(path) for path in (output, film) if path is not None)
    text = " ".join(f"({row}, {col})" for row, col in chosen)
    click.echo(f"{name}: {found.t[-1]:.4g} time constants, cells {text} -> {written}")


@click.command(
    epilog=examples(
        "cnnsim robust edge -o curve.png",
        "cnnsim robust hole-filler --draws 100 -o curve.png",
        "cnnsim robust corner --json",
    )
)
@click.argument("name")
@click.option("-o", "--output", type=_FILE, help="Where the curves go (PNG, SVG, PDF).")
@click.option("--draws", type=click.IntRange(1, 10_000), default=40, show_default=True, help="Random chips a level.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@_json
def robust(name: str, output: Path | None, draws: int, seed: int, as_json: bool) -> None:
    """Tell how precise a chip must be for template NAME.

    The margin, and the share of wrong cells under random errors of the entries (0.1 % to 20 %), entries of 3 to 12
    bits, and noise on the picture.
    """
    from cnnsim.prototyping.robust.robust import measure

    with _progress(name) as track:
        found = measure(library.load(name), draws=draws, seed=seed, track=track)
    if output is not None:
        from cnnsim.prototyping.robust.plot import draw_robustness

        draw_robustness(found, output)
    if as_json:
        curves = {kind: vars(getattr(found, kind)) for kind in ("entries", "bits", "noise")}
        print_json({"template": name, "margin": vars(found.margin), "judged_on": found.judged_on, **curves,
                    "bits_needed": found.bits_needed(), "draws": draws, "seed": seed})  # fmt: skip
        return
    click.echo(f"{name}, judged on {found.judged_on}")
    margin = found.margin
    if margin.value is None:
        click.echo(margin.why)
    else:
        click.echo(f"margin          {margin.value:.4g} ({margin.why})")
        assert margin.tolerated is not None
        click.echo(f"entry errors    {'' if margin.exact else 'at least '}{100 * margin.tolerated:.3g} % are harmless")
    sigma, noise, bits = found.entries.largest_without_error(), found.noise.largest_without_error(), found.bits_needed()
    click.echo(f"random errors   {_level(sigma, 100, ' %')} (σ) without a wrong cell in {draws} draws")
    click.echo(f"bits            {'more than 12' if bits is None else bits} needed")
    click.echo(f"noise           {_level(noise, 1, '')} (σ; black to white is 2) without a wrong cell")
    if output is not None:
        click.echo(f"-> {output}")


def _level(level: float | None, scale: float, unit: str) -> str:
    return "none" if level is None else f"up to {scale * level:g}{unit}"


@contextmanager
def _progress(what: str) -> Iterator[Any]:
    """Give a function that goes through a list and shows how far it is, on stderr and only on a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:

        def track(levels: Iterable[Any]) -> Iterator[Any]:
            yield from bar.track(list(levels), description=what)

        yield track


@click.command(
    epilog=examples(
        'cnnsim design --rule "c and ring8 < 8" --name my-edge -o designs/',
        'cnnsim design --rule "all9 % 2 == 1" --name parity -o designs/',
        'cnnsim design --rule "c xor x" --name differs -o designs/ --json',
        "cnnsim design --table rule.toml --name my-rule -o designs/",
        "cnnsim design --pair before.png=after.png --name learned -o designs/",
        "cnnsim design --pair before.png=after.png --coupled --state 1 --name filled -o designs/",
    )
)
@click.option("--rule", "text", help="An expression, such as 'c and (n + e + s + w) < 4'; names as above.")
@click.option("--table", type=_FILE, help="A truth table: TOML with black, white (lists of windows) and default.")
@click.option("--pair", "pairs", multiple=True, metavar="INPUT=OUTPUT", help="Two pictures: what should become what.")
@click.option("--name", required=True, help="Name of the template, and of its files.")
@click.option("-o", "--output", type=_FILE, required=True, help="Folder for the files.")
@click.option("--norm", type=click.Choice(["sum", "largest"]), default="sum", show_default=True,
              help="Make the margin large compared with the sum of |weights|, or with the largest.")  # fmt: skip
@click.option("--boundary", default="fixed:-1", show_default=True, help=f"{BOUNDARY_FORMS}.")
@click.option("--coupled", is_flag=True, help="Fit a template with neighbours in A to the pairs, by evolution.")
@click.option("--state", default="picture", show_default=True, help="For --coupled: x(0), the picture or a number.")
@click.option("--symmetry", type=click.Choice(["all", "mirror", "none"]), default="all", show_default=True,
              help="For --coupled: entries that are equal in all directions, left and right, or none.")  # fmt: skip
@click.option("--generations", type=click.IntRange(1), default=60, show_default=True, help="For --coupled.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="For --coupled.")
@_json
def design(
    text: str | None, table: Path | None, pairs: tuple[str, ...], name: str, output: Path, boundary: str,
    coupled: bool, as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Find templates for a rule over the 3 x 3 window, and write them with worked examples.

    In a rule c n ne e se s sw w nw are 1 for black and 0 for white, x is the cell's own initial state; ring4, ring8 and
    all9 are sums; and or xor not, comparisons, + - * % and brackets work as usual. One template of the largest margin
    is found if there is one; otherwise a certificate says why not, and a program of a few templates is written.
    """
    import re

    if (text is not None) + (table is not None) + bool(pairs) != 1:
        raise InputError("a rule is wanted: exactly one of --rule, --table and --pair (as often as there are pairs)")
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name):
        raise InputError(f"name {name!r}; small letters, digits and hyphens wanted, such as my-edge")
    from cnnsim.prototyping.design import report

    around = parse_boundary(boundary)
    if coupled:
        if not pairs:
            raise InputError("--coupled fits a template to pictures: give --pair INPUT=OUTPUT")
        with _progress(name) as track:
            facts, lines = report.fitted(pairs, name, output, around, options, track)
    else:
        facts, lines = report.designed(text, table, pairs, name, output, around, options["norm"])
    if as_json:
        print_json(facts)
    else:
        click.echo("\n".join(lines))
