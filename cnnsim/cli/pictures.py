"""Pictures of the commands: options of reading; results written as a file, numbered files or a film."""

from collections.abc import Sequence
from glob import escape
from pathlib import Path
from typing import Any

import click
import numpy as np
from PIL import Image

from cnnsim.library.entry import LibraryEntry
from cnnsim.network import LayeredTemplate
from cnnsim.support import Array, InputError
from cnnsim.support.command_files import claim
from cnnsim.support.files import check_folder, check_place, make_folder
from cnnsim.support.pictures.film import FILM_ENDINGS, filming, is_film, video_library
from cnnsim.support.pictures.picture import ARRAY_ENDINGS, check_bits, write_picture
from cnnsim.support.pictures.pixels import check_reading
from cnnsim.support.pictures.read import planes_of, read_pictures, sequence_of
from cnnsim.support.pictures.sequence import PictureOptions

FRAME_RATE = 10.0
"""Pictures a second of a film of results, if the input has no rate."""

picture_argument = click.argument(
    "pictures", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="PICTURE..."
)
binary_option = click.option("--binary", is_flag=True, help="Make the pictures black and white before the run.")
range_option = click.option(
    "--range", "levels", metavar="BLACK,WHITE", callback=lambda _context, _option, text: parse_levels(text),
    help="The numbers of black and white, for grey pictures whose file does not tell: 0,4095.",
)  # fmt: skip


bits_option = click.option(
    "--bits", type=click.Choice(["8", "16", "32"]), default="8", callback=lambda _context, _option, text: int(text),
    help="Bits of a grey level: 16 in PNG and TIFF, 32 (floats) in TIFF; .npy and .npz hold the numbers [8].",
)  # fmt: skip


def parse_levels(text: str | None) -> tuple[float, float] | None:
    """Read "BLACK,WHITE" as two numbers.

    Raises:
        InputError: something else.
    """
    if text is None:
        return None
    try:
        black, white = (float(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"range {text!r}; BLACK,WHITE wanted, such as 0,4095") from error
    return black, white


def read_for(entry: LibraryEntry, paths: Sequence[Path], reading: PictureOptions, *, batch: bool) -> Array:
    """Return the picture (rows, cols) for a template, or the sequence (n, rows, cols) if it takes one.

    With ``batch`` a template for one picture takes several as well, as independent grids.

    Raises:
        InputError: several pictures for a template that takes one; pictures of different sizes.
    """
    check_reading(reading.levels, reading.dtype)
    whole = sequence_of(paths, reading)
    one = entry.frame_time is None and (not batch or isinstance(entry.network, LayeredTemplate))
    if one and (count := whole.count()) > 1:
        raise InputError(f"template {entry.name!r} takes one picture, {count} were given")
    planes = planes_of(whole, reading.dtype)
    return planes if entry.frame_time is not None or len(planes) > 1 else planes[0]


def read_beside(path: Path | None, what: str, pictures: Array, reading: PictureOptions) -> Array | None:
    """Return a second picture, or one for each picture of a batch.

    Raises:
        InputError: another number of pictures, or as `read_pictures`.
    """
    if path is None:
        return None
    planes = read_pictures(path, binary=reading.binary, levels=reading.levels, dtype=reading.dtype)
    if len(planes) == 1:
        return planes[0]
    count = len(pictures) if pictures.ndim == 3 else 1
    if len(planes) != count:
        raise InputError(f"{what}: {len(planes)} pictures for {count}; one or {count} wanted")
    return planes


def check_output(
    path: Path | None, *, film: bool, name: str = "", count: int | None = None, bits: int = 8
) -> None:  # fmt: skip
    """Check before the run that `write_planes` can write a path; None is skipped.

    ``count``: number of pictures, None for one without a number.

    Raises:
        InputError: the folder is missing, no picture (or with ``film`` no film) has this ending or ``bits`` a grey
            level, or as `claim`.
    """
    if path is None:
        return
    if path.is_dir() or not path.suffix:
        check_folder(path)
    else:
        check_place(path)
    claim(*planned(path, film=film, name=name, count=count))
    if path.is_dir() or not path.suffix:
        return
    if film and is_film(path):
        check_film(path)
        return
    check_bits(path, bits)
    if (
        path.suffix.lower() not in ARRAY_ENDINGS
        and Image.registered_extensions().get(path.suffix.lower()) not in Image.SAVE
    ):
        raise InputError(f"cannot write {path}: unknown file extension: {path.suffix}")


def check_film(path: Path | None) -> None:
    """Check before the run that a film can be written; None is skipped.

    Raises:
        InputError: the folder is missing, no film has this ending, or a video needs PyAV.
    """
    if path is None:
        return
    if not is_film(path):
        raise InputError(f"cannot write {path}: a film is one of {', '.join(FILM_ENDINGS)}")
    check_place(path)
    if path.suffix.lower() != ".gif":
        video_library(path)


def check_plot(path: Path | None) -> None:
    """Check before the run that a plot can be written; None is skipped.

    Raises:
        InputError: the folder is missing, or matplotlib does not write this ending.
    """
    if path is None:
        return
    from matplotlib.backend_bases import FigureCanvasBase  # slow to import, and only needed for plots

    check_place(path)
    known = sorted(FigureCanvasBase.filetypes)
    if path.suffix[1:].lower() not in known:
        raise InputError(f"cannot write {path}: a plot is one of .{', .'.join(known)}")


def write_planes(y: Array, path: Path, *, film: bool, name: str = "", bits: int = 8) -> list[Path]:
    """Write a picture, or several as numbered files, or as one film if ``film`` and the path allow it.

    A path that is a folder, or has no ending, is the folder for PNG files with that ``name``; ``bits`` of a grey level.
    """
    if path.is_dir() or not path.suffix:
        make_folder(path)
    paths = planned(path, film=film, name=name, count=None if y.ndim == 2 else len(y))
    if y.ndim > 2 and film and is_film(path):
        with filming(path, FRAME_RATE) as add:
            for picture in y:
                add(picture)
        return paths
    for picture, target in zip(y[None] if y.ndim == 2 else y, paths, strict=True):
        write_picture(picture, target, bits=bits)
    return paths


def planned(path: Path, *, film: bool, name: str, count: int | None) -> list[Path]:
    """Return the files that `write_planes` writes: one film, one picture if ``count`` is None, or numbered pictures."""
    if path.is_dir() or not path.suffix:
        path /= f"{name}.png"
    elif film and is_film(path):
        count = None
    return [path] if count is None else [path.with_stem(f"{path.stem}-{number}") for number in range(count)]


def arrow(paths: Sequence[Any]) -> str:
    """Return " -> PATH", or " -> FIRST to LAST" of numbered files, and other files after commas.

    It is the end of the lines that commands print.

    Files with higher numbers are of an earlier run, and are listed.
    """
    if not paths:
        return ""
    stems = {str(path).rpartition("-")[0] for path in paths}
    if len(stems) > 1 or "" in stems:  # not all are numbered files of one name
        return " -> " + ", ".join(map(str, paths))
    old = _numbered_beyond(Path(paths[-1])) if len(paths) > 1 else []
    stale = f"; of an earlier run: {old[0]}" + (f" to {old[-1]}" if len(old) > 1 else "") if old else ""
    return f" -> {paths[0]}" + (f" to {paths[-1]}" if len(paths) > 1 else "") + stale


def _numbered_beyond(last: Path) -> list[Path]:
    stem, _, number = last.stem.rpartition("-")
    if not number.isdecimal():
        return []
    numbers = {path: path.stem[len(stem) + 1 :] for path in last.parent.glob(f"{escape(stem)}-*{last.suffix}")}
    later = {path: int(text) for path, text in numbers.items() if text.isdecimal() and int(text) > int(number)}
    return sorted(later, key=lambda path: later[path])


def as_map(values: Array, what: str, pictures: Array) -> Any:
    """Return a map (mask, bias) for pictures.

    Raises:
        InputError: its shape differs from that of the pictures.
    """
    if values.shape[-2:] != pictures.shape[-2:]:
        raise InputError(f"{what} has shape {values.shape}, the picture {pictures.shape}; one shape wanted")
    return np.broadcast_to(values, (*pictures.shape[:-2], *values.shape[-2:])) if pictures.ndim == 3 else values
