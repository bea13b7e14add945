"""The commands `run` and `program`: a template or a program run on pictures."""

from pathlib import Path
from typing import Any, get_args

import click
import numpy as np

from cnnsim import backends, library
from cnnsim.library.entry import LibraryEntry
from cnnsim.network import parse_boundary
from cnnsim.network.boundary import BOUNDARY_FORMS
from cnnsim.planning.savings import Saving
from cnnsim.planning.scheme import ADAPTIVE, SCHEMES
from cnnsim.support import Array, Floats, InputError
from cnnsim.support.command_line import examples, print_json, watched
from cnnsim.support.picture import read_picture, write_film, write_picture

backend_option = click.option("--backend", type=click.Choice(backends.NAMES), default="cpu", show_default=True)
device_option = click.option("--device", help="OpenCL device, by number or part of its name; see `cnnsim devices`.")
without_option = click.option(
    "--without", multiple=True, type=click.Choice(get_args(Saving)), help="Do without a saving, for comparison."
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")


@click.command(
    epilog=examples(
        "cnnsim run edge square.png -o edge.png",
        "cnnsim run hole-filler scan.png -o filled.png --binary --trajectory wave.gif",
        "cnnsim run diffusion photo.jpg -o soft.png --time 3 --boundary zero-flux",
        "cnnsim run recall mask.png --state marker.png -o found.png",
    )
)
@click.argument("name")
@click.argument("pictures", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="PICTURE...")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Where the output picture goes.")
@click.option("--state", type=click.Path(path_type=Path), help="The second picture, for templates that take one.")
@click.option("--binary", is_flag=True, help="Make the pictures black and white before the run.")
@click.option("--boundary", help=f"{BOUNDARY_FORMS} instead of the template's own.")
@click.option("--time", "duration", type=float, help="Run this many time constants instead of the template's own rule.")
@click.option(
    "--scheme", type=click.Choice([*SCHEMES, ADAPTIVE]), help="Integration scheme instead of the plan's choice."
)
@click.option("--step", type=float, help="Step in time constants.")
@click.option(
    "--cell", type=click.Choice(["chua-yang", "full-range"]), help="Cell model instead of the template's own."
)
@without_option
@click.option("--dtype", type=click.Choice(["float32", "float64"]), help="Precision of the backend.")
@click.option("--trajectory", type=click.Path(path_type=Path), help="Also write the output over time as a GIF.")
@backend_option
@device_option
@json_option
def run(
    name: str, pictures: tuple[Path, ...], output: Path | None, state: Path | None, binary: bool,
    trajectory: Path | None, backend: str, device: str | None, dtype: str | None, as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Run template NAME on PICTURE (any format Pillow reads; black is +1, white -1).

    Templates for moving pictures take several, one a frame; of a network of layers each layer has its own output.
    """
    from cnnsim.transient import NotSettledError, run_transient
    from cnnsim.transient import trajectory as run_over_time

    entry = library.load(name)
    given: dict[str, Any] = {key: value for key, value in options.items() if value is not None}
    if "boundary" in given:
        given["boundary"] = parse_boundary(given["boundary"])
    second = None if state is None else read_picture(state, binary=binary)
    task = {**entry.task(read_frames(entry, pictures, binary=binary), second), **given}
    where = backends.get(backend, dtype, device)
    try:
        result = run_transient(entry.network, **task, backend=where)
    except NotSettledError as error:
        if output is not None:
            _write(error.result.y, output)
        raise
    if output is not None:
        _write(result.y, output)
    if trajectory is not None:
        end = result.t if np.isfinite(result.t) else 10.0
        film = run_over_time(entry.network, **task, until=max(end, 1.0), frames=60, backend=where)
        write_film([y for _, y in watched(film, "film", 61)], trajectory)
    black = int((result.y > 0).sum())
    size = " x ".join(str(n) for n in result.y.shape)
    if as_json:
        facts = {"template": name, "t": result.t, "settled": result.settled, "rate": result.rate}
        print_json({**facts, "black": black, "cells": result.y.size, "shape": result.y.shape})
    else:
        ended = (
            "at rest" if not np.isfinite(result.t) else f"t = {result.t:g}" + (", settled" if result.settled else "")
        )
        click.echo(f"{name}: {size} cells, {ended}, {black} black" + _arrow(output))


def read_frames(entry: LibraryEntry, pictures: tuple[Path, ...], *, binary: bool) -> Floats:
    """Return the picture (rows, cols) for a template, or the sequence (frames, rows, cols) if it takes one.

    Raises:
        InputError: several pictures for a template that takes one, or frames of different sizes.
    """
    frames = [read_picture(picture, binary=binary) for picture in pictures]
    if len(frames) > 1 and entry.frame_time is None:
        raise InputError(f"template {entry.name!r} takes one picture, {len(frames)} were given")
    if len({frame.shape for frame in frames}) > 1:
        raise InputError(f"frames of different sizes: {', '.join(str(frame.shape) for frame in frames)}")
    return np.stack(frames) if entry.frame_time is not None else frames[0]


@click.command(
    epilog=examples(
        "cnnsim program opening --input picture=scan.png -o out/",
        "cnnsim program gray-opening --input picture=photo.png --set radius=2 -o out/",
        "cnnsim program my-program.toml --input a=left.png --input b=right.png -o out/ --json",
    )
)
@click.argument("file")
@click.option("--input", "pairs", multiple=True, metavar="NAME=PICTURE", help="A picture for an input plane.")
@click.option("--set", "settings", multiple=True, metavar="NAME=NUMBER", help="A number for one of its parameters.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder for the output planes, one PNG each.")
@click.option("--binary", is_flag=True, help="Make the pictures black and white before the run.")
@backend_option
@device_option
@json_option
def program(
    file: str,
    pairs: tuple[str, ...],
    settings: tuple[str, ...],
    output: Path | None,
    binary: bool,
    backend: str,
    device: str | None,
    as_json: bool,
) -> None:
    """Run an analogic program: FILE is a TOML file, or the name of a program of the library."""
    from cnnsim.program.file import load_program
    from cnnsim.program.machine import UniversalMachine

    parsed = load_program(file, parameters={key: _number(key, text) for key, text in _pairs("--set", settings)})
    pictures = {key: read_picture(path, binary=binary) for key, path in _pairs("--input", pairs)}
    results = UniversalMachine(backends.get(backend, device=device)).run(parsed, **pictures)
    numbers: dict[str, Any] = {}
    for key, value in results.items():
        if isinstance(value, int):
            numbers[key] = value
            continue
        numbers[key] = {"black": int((value > 0).sum()), "shape": value.shape}
        if output is not None:
            output.mkdir(parents=True, exist_ok=True)
            write_picture(value, output / f"{key}.png")
    if as_json:
        print_json({"program": parsed.name, "outputs": numbers})
        return
    for key, value in numbers.items():
        text = f"{value['black']} black cells" if isinstance(value, dict) else str(value)
        click.echo(f"{key}: {text}" + _arrow(output / f"{key}.png" if output and isinstance(value, dict) else None))


def _pairs(option: str, pairs: tuple[str, ...]) -> list[tuple[str, str]]:
    for pair in pairs:
        if "=" not in pair:
            raise InputError(f"{option} {pair!r}; NAME=VALUE wanted")
    return [(key, value) for key, _, value in (pair.partition("=") for pair in pairs)]


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise InputError(f"--set {name}={text}; a number wanted") from error
    return int(value) if value.is_integer() else value


def _write(y: Array, path: Path) -> None:
    """Write a picture; of several layers each its own, numbered."""
    for number, layer in enumerate(y if y.ndim == 3 else []):
        write_picture(layer, path.with_stem(f"{path.stem}-{number}"))
    if y.ndim == 2:
        write_picture(y, path)


def _arrow(path: Path | None) -> str:
    return "" if path is None else f" -> {path}"
