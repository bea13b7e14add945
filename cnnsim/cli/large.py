"""The options `--engine` and `--store`: large pictures computed block by block, on processes or a Dask cluster."""

from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.cli.pictures import arrow, check_output
from cnnsim.library.entry import LibraryEntry
from cnnsim.support import InputError
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import print_json
from cnnsim.support.files import check_folder, make_folder
from cnnsim.support.pictures.sequence import PictureOptions, PictureSequence, size_text
from cnnsim.support.terminal import say

if TYPE_CHECKING:
    from cnnsim.program.machine import UniversalMachine

STRIP = 1024
"""Rows that are read at a time."""
engine_option = click.option(
    "--engine", metavar="ENGINE",
    help="Compute in blocks on the disk: 'processes' of this machine, or 'dask=ADDRESS' of a Dask scheduler.",
)  # fmt: skip
store_option = click.option(
    "--store", type=click.Path(path_type=Path), metavar="DIR",
    help="Folder of the blocks; a stopped run resumes from it.",
)  # fmt: skip
workers_option = click.option(
    "--workers", type=click.IntRange(1), help="Number of worker processes; default: one a core."
)
block_option = click.option("--block", type=click.IntRange(8), help="Number of rows and columns of a block.")


def check_engine_options(engine: str | None, store: Path | None, workers: int | None, block: int | None) -> None:
    """Check that options of an engine are given only with an engine.

    Raises:
        InputError: an option is given without an engine.
    """
    if engine is not None or store is not None:
        return
    for option, value in (("--workers", workers), ("--block", block)):
        if value is not None:
            raise InputError(f"{option} {value} without an engine; --engine processes, or dask=ADDRESS, wanted")


def run_large(
    entry: LibraryEntry, files: dict[str, Path | None], where: Backend, output: Path | None, as_json: bool,
    reading: PictureOptions, given: dict[str, Any], chosen: dict[str, Any],
) -> None:  # fmt: skip
    """Run a template on one picture in supersteps, and write and report the result as `run` does.

    ``files``: by the name of a plane, "picture", "state", "mask" or "bias".
    """
    from cnnsim.supersteps.engine import Engine
    from cnnsim.supersteps.pictures import open_large, write_large
    from cnnsim.transient import run_transient

    if output is not None and (output.is_dir() or not output.suffix):
        output /= f"{entry.name}.png"
        check_folder(output.parent)
        claim(output)
    elif output is not None and output.suffix.lower() == ".npy":
        claim(output)
    else:
        check_output(output, film=False)
    planes = {
        name: open_large(path, binary=reading.binary, levels=reading.levels)
        for name, path in files.items() if path is not None
    }  # fmt: skip
    shape = planes["picture"].shape
    stand_in, second = (np.broadcast_to(-np.ones((1, 1)), shape) for _ in range(2))  # the roles need no pixels
    task = entry.task(stand_in, second if "state" in planes else None)
    for name, plane in task.items():
        if plane is stand_in:
            task[name] = planes["picture"]
        elif plane is second:
            task[name] = planes["state"]
    task |= {name: planes[name] for name in ("mask", "bias") if name in planes}
    result = run_transient(
        entry.network, **entry.changed(task, given), backend=where, engine=Engine(chosen["engine"] or "processes", **{
            key: chosen[key] for key in ("store", "workers", "side")
        }),
    )  # fmt: skip
    if output is not None:
        make_folder(output.parent)
        write_large(result.x, output)
    black = black_cells(result.x)
    if as_json:
        facts = {"template": entry.name, "t": result.t, "settled": result.settled, "rate": result.rate}
        print_json({**facts, "black": black, "cells": result.x.size, "shape": result.x.shape})
        return
    ended = "at rest" if not np.isfinite(result.t) else f"t = {result.t:g}" + (", settled" if result.settled else "")
    cells = " x ".join(map(str, shape))
    say(f"{entry.name}: {cells} cells, {ended}, {black} black" + arrow([] if output is None else [output]))


def sequence_of_large(paths: list[str], reading: PictureOptions, _key: str = "") -> PictureSequence:
    """Return large pictures, one per file, as a sequence whose planes are read in parts.

    Raises:
        InputError: as `open_large`; pictures of different sizes.
    """
    from cnnsim.supersteps.pictures import open_large

    planes = [open_large(Path(path), binary=reading.binary, levels=reading.levels) for path in paths]
    for path, plane in zip(paths, planes, strict=True):
        if plane.shape != planes[0].shape:
            sizes = size_text(planes[0].shape), size_text(plane.shape)
            raise InputError(f"pictures of different sizes: {paths[0]} is {sizes[0]}, {path} {sizes[1]}")
    return PictureSequence(paths[0], planes[0].shape, lambda: len(planes), lambda: iter(planes))


def machine_on_engine(where: Backend, chosen: dict[str, Any], stack: ExitStack) -> "UniversalMachine":
    """Return a machine with planes on the disk, in the chosen store or in a temporary one that ``stack`` removes."""
    from cnnsim.program.machine import UniversalMachine
    from cnnsim.supersteps.engine import Engine

    store = chosen["store"] or Path(stack.enter_context(TemporaryDirectory(prefix="cnnsim-store-")))
    engine = Engine(chosen["engine"] or "processes", store, chosen["workers"], chosen["side"])
    return UniversalMachine(where, engine=engine)


def black_cells(plane: Any) -> int:
    """Return the number of black cells of a plane."""
    return sum(int((np.asarray(plane[..., r0 : r0 + STRIP, :]) > 0).sum()) for r0 in range(0, plane.shape[-2], STRIP))


def write_result(plane: Any, path: Path) -> None:
    """Write a stored plane as a picture."""
    from cnnsim.supersteps.pictures import write_large

    write_large(plane, path, follow=False)
