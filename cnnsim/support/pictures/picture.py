"""Picture files read and written as CNN values, and pictures drawn in text."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.support.errors import InputError, shown
from cnnsim.support.files import named_file, writing
from cnnsim.support.keywords import spelled
from cnnsim.support.limits import check_plain, reason
from cnnsim.support.memory import check_memory
from cnnsim.support.pictures.pixels import Levels, check_labels, check_reading, least_bytes, pixel_bytes, values_of
from cnnsim.support.pictures.upright import read_through, upright_size
from cnnsim.support.types import Array, Floats
from cnnsim.support.values import as_numbers, is_whole, largest

_RAMP = ".:-=+*%#"
"""Characters from white to black."""
_MORE_THAN_PICTURES = {"MPO", "PSD"}
"""Formats whose further frames are no pictures of a sequence: a camera's previews, the layers of a drawing."""
_LINE, _LINE_COLOUR = 3, (230, 120, 40)
"""Width [pixels] and colour of the line between planes: no grey level, so that it is no column of cells."""
_TOO_LARGE = "cut it into tiles, make it smaller, or use a machine with more memory"


@spelled()
def read_picture(
    path: str | Path, *, binary: bool = False, levels: Levels | None = None, dtype: Any = np.float64
) -> Array:
    """Read any picture Pillow knows as CNN values (rows, cols); colours become grey, transparency white.

    Arguments: ``binary`` makes everything darker than mid-grey +1 and the rest -1; ``levels`` (black, white) are the
    numbers that stand for them in a grey picture whose file does not say it; ``dtype`` of the array.

    Raises:
        InputError: the file is missing or no picture, holds several, has a range that is not known (see
            `cnnsim.support.pictures.pixels`), or does not fit into memory.
    """
    check_reading(levels, dtype)
    with opened(path) as image:
        if pictures_in(image) > 1:
            raise InputError(f"{path} holds {pictures_in(image)} pictures; one wanted (read_pictures reads all)")
        check_size(image, str(path), np.dtype(dtype).itemsize)
        check_labels(image, str(path), levels)
        return values_of(image, str(path), binary=binary, levels=levels, dtype=dtype)


@contextmanager
def opened(path: str | Path) -> Iterator[Image.Image]:
    """Open a picture file of any size; nothing but its head is read as yet.

    Raises:
        InputError: the file is missing or no picture, also where that shows only later.
    """
    named = named_file(path)
    try:
        check_plain(named, "picture")
        with _AnySize(), Image.open(path) as image:
            read_through(image)
            yield image
    except InputError:
        raise
    except FileNotFoundError as error:
        raise InputError(f"no picture {path}") from error
    except MemoryError as error:
        raise InputError(f"{path}: no memory for what it says it holds; a smaller or a whole one wanted") from error
    except (
        Exception
    ) as error:  # Pillow's decoders let through whatever goes wrong inside: AssertionError, TypeError ...
        raise InputError(f"{path} is no picture that Pillow can read: {reason(error)}") from error


def pictures_in(image: Image.Image) -> int:
    """Return how many pictures follow one another in a file."""
    return 1 if image.format in _MORE_THAN_PICTURES else int(getattr(image, "n_frames", 1))


def check_size(image: Image.Image, name: str, cell_bytes: int) -> None:
    """Refuse a picture that does not fit into the memory that is free, before its pixels are read.

    Or that cannot be in the file, however well it is packed; ``name`` is its path.

    Raises:
        InputError: both sizes, and what to do.
    """
    check_whole_file(image, name)
    rows, cols = upright_size(image)
    what = f"{name}: reading {rows} x {cols} pixels"
    check_memory(what, rows * cols * (pixel_bytes(image.mode) + cell_bytes), _TOO_LARGE)


def check_whole_file(image: Image.Image, name: str) -> None:
    """Refuse a picture whose pixels cannot be in the file, however well it is packed; ``name`` is its path.

    Raises:
        InputError: both sizes.
    """
    rows, cols = upright_size(image)
    least, there = least_bytes(image), Path(name).stat().st_size
    if there < least:
        raise InputError(
            f"{name}: {there} bytes that say they are {rows} x {cols} pixels, which take {least:.0f} at least; a whole "
            "file wanted"
        )


class _AnySize:
    """Sets Pillow's own limit aside while pictures are read, in whatever thread; `check_size` takes its place.

    That limit is a number for all machines: it knows nothing of the memory that is free.
    """

    _lock, _open = Lock(), 0
    _usual: int | None = None

    def __enter__(self) -> None:
        with _AnySize._lock:
            if not _AnySize._open:
                _AnySize._usual, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
            _AnySize._open += 1

    def __exit__(self, *_: object) -> None:
        with _AnySize._lock:
            _AnySize._open -= 1
            if not _AnySize._open:
                Image.MAX_IMAGE_PIXELS = _AnySize._usual


def to_image(values: Array, scale: int = 1) -> Image.Image:
    """Return CNN values (rows, cols) as a grey picture, each cell ``scale`` pixels wide; booleans: True is black.

    Planes (layers, rows, cols) lie side by side.
    """
    values = np.concatenate(list(values), axis=1) if values.ndim == 3 else values
    grey = np.empty(values.shape, np.uint8)
    for row, out in zip(values, grey, strict=True):  # row by row: a whole plane in between would cost memory
        out[:] = np.where(row, 0, 255) if row.dtype == bool else np.rint((1.0 - np.clip(row, -1, 1)) * 127.5)
    return Image.fromarray(grey if scale == 1 else np.kron(grey, np.ones((scale, scale), dtype=np.uint8)))


def to_png(values: Array, least: int = 192) -> bytes:
    """Return CNN values (..., rows, cols) as a PNG file, cells large enough that the picture has ``least`` pixels.

    Of several planes each stands for itself, a coloured line between it and the next.
    """
    rows, cols = values.shape[-2:]
    scale = max(1, least // max(rows, cols))
    planes = [to_image(plane, scale) for plane in values.reshape(-1, rows, cols)]
    whole = planes[0]
    if len(planes) > 1:
        wide = cols * scale + _LINE
        whole = Image.new("RGB", (wide * len(planes) - _LINE, rows * scale), _LINE_COLOUR)
        for number, plane in enumerate(planes):
            whole.paste(plane.convert("RGB"), (number * wide, 0))
    file = BytesIO()
    whole.save(file, format="PNG")
    return file.getvalue()


@spelled()
def write_picture(values: Array, path: str | Path, scale: int = 1, *, follow: bool = True) -> None:
    """Write CNN values as a picture; the format follows the name's ending, ``follow`` as in `writing`.

    Raises:
        InputError: Pillow does not know the ending, or the file cannot be written; values that are no CNN values.
    """
    if not is_whole(scale) or scale < 1:
        raise InputError(f"scale {scale!r}; a whole number of pixels a cell, at least 1, wanted")
    if not (isinstance(values, np.ndarray) and values.dtype == bool):
        values = as_numbers("picture", values)
    if values.ndim not in (2, 3):
        raise InputError(f"{path}: a picture of shape {values.shape}; (rows, cols) wanted")
    if not np.isfinite(largest(values)):
        raise InputError(f"{path}: a picture that holds {values[~np.isfinite(values)][0]}; finite numbers wanted")
    with writing(path, follow=follow) as beside:
        to_image(values, scale).save(beside)


def _cell(value: float) -> float:
    return (1.0 if value else -1.0) if isinstance(value, bool) else float(value)


def parse_ascii(rows: Iterable[str | Sequence[float]]) -> Floats:
    """Read a picture drawn in text: ``#`` is +1, ``.`` is -1; a row of numbers stands for itself, true is black.

    Raises:
        InputError: another character, something that is no number, or rows of different length.
    """
    values: list[list[float]] = []
    for number, row in enumerate(rows, start=1):
        if isinstance(row, str):
            strange = set(row) - {"#", "."}
            if strange:
                raise InputError(
                    f"row {number} of a picture holds {sorted(strange)[0]!r}; '#' (black) and '.' (white) wanted"
                )
            values.append([1.0 if character == "#" else -1.0 for character in row])
        else:
            try:
                values.append([_cell(value) for value in row])
            except (TypeError, ValueError, OverflowError) as error:
                what = f"row {number} of a picture is {shown(row)}"
                raise InputError(f"{what}; a text or a list of numbers wanted") from error
        if len(values[-1]) != len(values[0]):
            raise InputError(f"row {number} of a picture has {len(values[-1])} cells, row 1 has {len(values[0])}")
    if not values or not values[0]:
        raise InputError("a picture without cells; at least 1 x 1 wanted")
    return np.array(values)


def to_ascii(values: Array) -> list[str]:
    """Draw CNN values as text, one string a row, from ``.`` (white) to ``#`` (black)."""
    values = np.where(values, 1.0, -1.0) if values.dtype == bool else np.clip(values, -1, 1)
    level = np.rint((values + 1) / 2 * (len(_RAMP) - 1)).astype(int)
    return ["".join(_RAMP[cell] for cell in row) for row in level]
