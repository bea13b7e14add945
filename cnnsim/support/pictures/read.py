"""Pictures and sequences of pictures from files, a folder, an animation, a video or a NumPy file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.support.errors import InputError
from cnnsim.support.files import named_file
from cnnsim.support.keywords import spelled
from cnnsim.support.memory import LARGE, check_memory
from cnnsim.support.pictures.arrays import of_array
from cnnsim.support.pictures.film import VIDEO_ENDINGS
from cnnsim.support.pictures.picture import FORMATS
from cnnsim.support.pictures.pixels import Levels, check_reading
from cnnsim.support.pictures.sequence import PictureOptions, PictureSequence, of_file, of_video, size_text
from cnnsim.support.progress import watcher
from cnnsim.support.values import Array


@spelled()
def read_picture(
    path: str | Path, *, binary: bool = False, levels: Levels | None = None, dtype: Any = np.float64
) -> Array:
    """Read one picture as CNN values (rows, cols); colours become grey, transparency white.

    Arguments: ``path`` as in `read_pictures`; ``binary`` makes everything darker than mid-grey +1 and the rest -1;
    ``levels`` (black, white) are the numbers that stand for them in a grey picture whose file does not say it;
    ``dtype`` of the array.

    Raises:
        InputError: the file is missing or no picture of one of `FORMATS`, holds several, has a range that is not known
            (see `cnnsim.support.pictures.pixels`), or does not fit into memory.
    """
    check_reading(levels, dtype)
    whole = sequence_of([path], PictureOptions(binary, levels, dtype))
    if (count := whole.count()) > 1:
        raise InputError(f"{path} holds {count} pictures; one wanted (read_pictures reads all)")
    return next(whole.pictures())


@spelled()
def read_pictures(
    *paths: str | Path, binary: bool = False, levels: Levels | None = None, dtype: Any = np.float64
) -> Array:
    """Read a sequence of pictures as CNN values (n, rows, cols).

    Arguments: ``paths`` picture files, a folder of them (in the order of their names, numbers as numbers), an
    animation (GIF, TIFF, ...), a video (with PyAV), or an .npy or .npz file of one plane or (n, rows, cols) planes; the
    rest as in `read_picture`.

    Raises:
        InputError: as `read_picture`; pictures of different sizes, none, or more than the memory holds.
    """
    check_reading(levels, dtype)
    return planes_of(sequence_of(list(paths), PictureOptions(binary, levels, dtype)), dtype)


def planes_of(whole: PictureSequence, dtype: Any) -> Array:
    """Return all pictures of a sequence (n, rows, cols).

    Raises:
        InputError: as `read_pictures`.
    """
    count, (rows, cols) = whole.count(), whole.shape
    size = count * rows * cols * np.dtype(dtype).itemsize
    check_memory(f"{whole.name}: reading {count} pictures of {rows} x {cols}", size, "give fewer or smaller ones")
    found = np.empty((count, rows, cols), dtype)
    reading, report = whole.pictures(), watcher() if found.size >= LARGE else None
    for number in range(count):
        if report is not None:
            report(number / count if count > 1 else None, f"reading {whole.name}")
        found[number] = next(reading)
    return found


def sequence_of(paths: Sequence[str | Path], reading: PictureOptions, key: str = "") -> PictureSequence:
    """Return the pictures of some files as one sequence; of an .npz file the array ``key``, or its only array.

    Raises:
        InputError: as `read_pictures`.
    """
    parts = [_part(named_file(path), reading, key) for path in paths]
    if not parts:
        raise InputError("no picture; one or more wanted")
    first = parts[0]
    for part in parts:
        if part.shape != first.shape:
            raise InputError(
                f"pictures of different sizes: {first.name} is {size_text(first.shape)}, "
                f"{part.name} {size_text(part.shape)}"
            )
    if len(parts) == 1:
        return first
    return PictureSequence(
        f"{first.name} to {parts[-1].name}", first.shape, lambda: sum(part.count() for part in parts),
        lambda: (picture for part in parts for picture in part.pictures()), first.rate,
        any(part.long for part in parts),
    )  # fmt: skip


def _part(path: Path, reading: PictureOptions, key: str) -> PictureSequence:
    if path.is_dir():
        known = {ending for ending, form in Image.registered_extensions().items() if form in (*FORMATS, "MPO")}
        files = [file for file in path.iterdir() if file.suffix.lower() in known and not file.name.startswith(".")]
        if not files:
            raise InputError(f"the folder {path} holds no picture; files such as 1.png, 2.png, ... wanted")
        return sequence_of([path / name for name in sorted((file.name for file in files), key=_in_order)], reading)
    if path.suffix.lower() in (".npy", ".npz"):
        return of_array(path, reading, key)
    if path.suffix.lower() in VIDEO_ENDINGS:
        return of_video(path, reading)
    return of_file(path, reading)


def _in_order(name: str) -> list[Any]:
    """Return a sort key that puts 2.png before 10.png."""
    return [int(part) if number % 2 else part.lower() for number, part in enumerate(re.split(r"([0-9]+)", name))]
