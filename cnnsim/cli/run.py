"""The command `run`: runs a template on a picture, a batch or a sequence."""

from pathlib import Path
from typing import Any, get_args

import click
import numpy as np

from cnnsim import backends, library
from cnnsim.backends.base import Backend
from cnnsim.cli.large import block_option, check_engine_options, engine_option, run_large, store_option, workers_option
from cnnsim.cli.pictures import (
    arrow,
    as_map,
    binary_option,
    bits_option,
    check_film,
    check_output,
    picture_argument,
    range_option,
    read_beside,
    read_for,
    write_planes,
)
from cnnsim.network import LayeredTemplate
from cnnsim.network.sides import RUN_BOUNDARY_FORMS, parse_run_boundary
from cnnsim.planning.savings import Saving
from cnnsim.planning.scheme import ADAPTIVE, SCHEMES
from cnnsim.solver.tolerance import parse_accuracy
from cnnsim.support import InputError
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option, watched
from cnnsim.support.pictures.film import write_film
from cnnsim.support.pictures.sequence import PictureOptions
from cnnsim.support.terminal import say

backend_option = click.option("--backend", type=click.Choice(backends.NAMES), default="cpu", show_default=True)
device_option = click.option("--device", help="OpenCL device, by number or part of its name; see `cnnsim devices`.")
threads_option = click.option(
    "--threads", type=click.IntRange(1), help="Threads of the cpu backend on large grids; all cores if not given."
)
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
        "cnnsim run diffusion photo.jpg -o softer.npy --accuracy 1e-5",
        "cnnsim run edge scans/ -o edges.png",
        "cnnsim run edge walk.mp4 -o edges.gif",
        "cnnsim run hole-filler scan.png --mask keep.png -o kept.png",
        "cnnsim run hole-filler scan.png --engine processes --store blocks/ -o full.png",
    )
)
@click.argument("name")
@picture_argument
@click.option(
    "-o", "--output", type=click.Path(path_type=Path),
    help="Where the output goes: a picture, or numbers (.npy, .npz); or a folder; several are numbered, or a film.",
)  # fmt: skip
@click.option("--state", type=click.Path(path_type=Path), help="The second picture, for templates that take one.")
@click.option("--mask", type=click.Path(path_type=Path), help="Fixed-state map: black cells keep their state.")
@click.option("--bias", type=click.Path(path_type=Path), help="Bias map, added to z: black adds 1, white takes 1 off.")
@bits_option
@binary_option
@range_option
@click.option("--boundary", help=f"{RUN_BOUNDARY_FORMS} instead of the template's own.")
@click.option("--time", "duration", type=float, help="Run this many time constants instead of the template's own rule.")
@click.option(
    "--scheme", type=click.Choice([*SCHEMES, ADAPTIVE]), help="Integration scheme instead of the plan's choice."
)
@click.option("--step", type=float, help="Step in time constants.")
@click.option(
    "--accuracy", help="Instead of scheme and step: the error allowed (1e-3), 'binary' (only signs count) or 'exact'."
)
@click.option(
    "--cell", type=click.Choice(["chua-yang", "full-range"]), help="Cell model instead of the template's own."
)
@without_option
@click.option("--dtype", type=click.Choice(["float32", "float64"]), help="Precision of the backend.")
@click.option(
    "--trajectory", type=click.Path(path_type=Path), help="Also write the output over time as a film (.gif, .mp4)."
)
@backend_option
@device_option
@threads_option
@engine_option
@store_option
@workers_option
@block_option
@replace_option
@json_option
def run(
    name: str, pictures: tuple[Path, ...], output: Path | None, state: Path | None, mask: Path | None,
    bias: Path | None, binary: bool, levels: tuple[float, float] | None, trajectory: Path | None, backend: str,
    device: str | None, threads: int | None, dtype: str | None, as_json: bool, engine: str | None,
    store: Path | None, workers: int | None, block: int | None, bits: int, **options: Any,
) -> None:  # fmt: skip
    """Run a template on a picture, a batch or a sequence.

    PICTURE has any format that Pillow reads; black is +1, white -1.

    Several pictures are files, a folder, a GIF, a video, .npy or .npz: templates for moving pictures take them as one
    sequence, others run on each by itself. Of a network of layers each layer has its own output.
    """
    from cnnsim.convergence import NotSettledError
    from cnnsim.transient import run_transient
    from cnnsim.transient import trajectory as run_over_time

    entry = library.load(name)
    given: dict[str, Any] = {key: value for key, value in options.items() if value is not None}
    if "boundary" in given:
        given["boundary"] = parse_run_boundary(given["boundary"])
    check_engine_options(engine, store, workers, block)
    check_film(trajectory)
    claim(trajectory)
    where: Backend = backends.get(backend, dtype, device, threads)
    if engine is not None or store is not None:
        if trajectory is not None:
            raise InputError("--trajectory with --engine; without one of them wanted")
        if bits != 8:
            raise InputError(f"--bits {bits} with --engine; a .npy file wanted")
        if len(pictures) != 1 or entry.frame_time is not None:
            raise InputError(f"{len(pictures)} pictures on an engine; a template for one picture, and one, wanted")
        files = {"picture": pictures[0], "state": state, "mask": mask, "bias": bias}
        chosen = {"engine": engine, "store": store, "workers": workers, "side": block}
        run_large(entry, files, where, output, as_json, PictureOptions(binary, levels), given, chosen)
        return
    accuracy = given.get("accuracy", entry.accuracy)
    finely = accuracy is not None and parse_accuracy(accuracy).dtype == "float64"
    reading = PictureOptions(binary, levels, np.dtype(np.float64) if finely else where.dtype)
    shown = read_for(entry, pictures, reading, batch=True)
    task = entry.changed(entry.task(shown, read_beside(state, "--state", shown, reading)), given)
    for key, path in (("mask", mask), ("bias", bias)):
        if (plane := read_beside(path, f"--{key}", shown, reading)) is not None:
            task[key] = as_map(plane, f"--{key}", task["state"])
    film = entry.frame_time is None and shown.ndim == 3
    layers = len(entry.network.layers) if isinstance(entry.network, LayeredTemplate) else None
    check_output(output, film=film, name=name, count=len(shown) if film else layers, bits=bits)
    try:
        result = run_transient(entry.network, **task, backend=where)
    except NotSettledError as error:
        if output is not None:
            write_planes(error.result.y, output, film=film, name=name, bits=bits)
        raise
    written: list[Path] = [] if output is None else write_planes(result.y, output, film=film, name=name, bits=bits)
    films = ""
    if trajectory is not None:
        end = result.t if np.isfinite(result.t) else 10.0
        over_time = run_over_time(entry.network, **task, until=max(end, 1.0), frames=60, backend=where)
        times, frames = zip(*watched(over_time, "film", 61), strict=True)
        write_film(frames, trajectory, times=times)
        films = f", {trajectory}" if written else arrow([trajectory])
    black = int((result.y > 0).sum())
    size = " x ".join(str(n) for n in result.y.shape)
    if as_json:
        facts = {"template": name, "t": result.t, "settled": result.settled, "rate": result.rate}
        facts |= {"distance": result.distance, "error": result.error, "how": result.how}
        facts |= {"undecided": result.undecided.tolist()}
        print_json({**facts, "black": black, "cells": result.y.size, "shape": result.y.shape})
    else:
        ended = (
            "at rest" if not np.isfinite(result.t) else f"t = {result.t:g}" + (", settled" if result.settled else "")
        )
        known = "" if np.isnan(result.error) else f", error {result.error:.2g}"
        say(f"{name}: {size} cells, {ended}{known}, {black} black" + arrow(written) + films)
        if result.how and not np.isnan(result.error):
            say(f"  {result.how}")
        if len(result.undecided):
            cells = [str(tuple(cell)) for cell in result.undecided[:8].tolist()] + ["..."] * (len(result.undecided) > 8)
            say(f"  {len(result.undecided)} cells are not decided: {' '.join(cells)}")
