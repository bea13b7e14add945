"""Picture files read and written as CNN values, and pictures as text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from cnnsim.support.errors import InputError, shown
from cnnsim.support.files import named_file, writing
from cnnsim.support.keywords import spelled
from cnnsim.support.limits import check_plain, reason
from cnnsim.support.memory import LARGE, check_memory
from cnnsim.support.pictures.pixels import pixel_bytes
from cnnsim.support.pictures.upright import read_through, upright_size
from cnnsim.support.progress import watcher
from cnnsim.support.values import Array, Floats, as_numbers, is_whole, largest

_RAMP = ".:-=+*%#"
"""Characters from white to black."""
FORMATS = (
    "PNG", "JPEG", "GIF", "BMP", "DIB", "PPM", "TIFF", "WEBP", "JPEG2000", "TGA", "PCX", "SGI", "ICO", "PSD", "QOI",
    "DDS", "FITS", "FLI", "IM", "MSP", "SUN", "XBM", "XPM", "AVIF",
)  # fmt: skip
"""Formats of pictures that are opened: those that Pillow decodes itself. EPS would start Ghostscript."""
_MORE_THAN_PICTURES = {"MPO", "PSD"}
"""Formats whose further frames are no sequence: previews of a camera, layers of a drawing."""
_LINE, _LINE_COLOUR = 3, (230, 120, 40)
"""Width [pixels] and colour of the line between planes, which no cell has."""
ARRAY_ENDINGS = (".npy", ".npz")
"""Endings of files that hold the numbers themselves."""
DEEP = {16: (".png", ".tif", ".tiff"), 32: (".tif", ".tiff")}
"""Bits of a grey level, and the endings of files that hold them."""
_TOO_LARGE = "cut it into tiles, make it smaller, or use a machine with more memory"


@contextmanager
def opened(path: str | Path) -> Iterator[Image.Image]:
    """Open a picture file of any size and read its header.

    Raises:
        InputError: the file is missing or no picture; also raised for errors inside the block.
    """
    named = named_file(path)
    try:
        check_plain(named, "picture")
        with _any_size(), Image.open(path, formats=FORMATS) as image:
            read_through(image)
            yield image
    except InputError:
        raise
    except FileNotFoundError as error:
        raise InputError(f"no picture {path}") from error
    except MemoryError as error:
        raise InputError(f"{path}: not enough memory; a smaller or a complete picture wanted") from error
    except Exception as error:  # Pillow's decoders raise AssertionError, TypeError and others for broken files
        raise InputError(f"{path} is no picture that Pillow can read: {reason(error)}") from error


def pictures_in(image: Image.Image) -> int:
    """Return the number of pictures in a file."""
    return 1 if image.format in _MORE_THAN_PICTURES else int(getattr(image, "n_frames", 1))


def check_size(image: Image.Image, name: str, cell_bytes: int) -> None:
    """Check, before its pixels are read, that a picture fits into the free memory; ``name`` is its path.

    Raises:
        InputError: with both sizes.
    """
    rows, cols = upright_size(image)
    what = f"{name}: reading {rows} x {cols} pixels"
    check_memory(what, rows * cols * (pixel_bytes(image.mode) + cell_bytes), _TOO_LARGE)


@contextmanager
def _any_size() -> Iterator[None]:
    """Disable Pillow's limit of pixels, which ignores the free memory; `check_size` replaces it."""
    usual, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = usual


def to_image(values: Array, scale: int = 1) -> Image.Image:
    """Return CNN values (rows, cols) as a grey picture, each cell ``scale`` pixels wide; booleans: True is black.

    Planes (layers, rows, cols) lie side by side.
    """
    values = np.concatenate(list(values), axis=1) if values.ndim == 3 else values
    grey = np.empty(values.shape, np.uint8)
    for row, out in zip(values, grey, strict=True):  # row by row: a temporary plane would cost memory
        out[:] = np.where(row, 0, 255) if row.dtype == bool else np.rint((1.0 - np.clip(row, -1, 1)) * 127.5)
    return Image.fromarray(grey if scale == 1 else np.kron(grey, np.ones((scale, scale), dtype=np.uint8)))


def to_png(values: Array, least: int = 192) -> bytes:
    """Return CNN values (..., rows, cols) as a PNG file that is at least ``least`` pixels wide or high.

    Several planes are side by side with a coloured line between them.
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
def write_picture(values: Array, path: str | Path, scale: int = 1, *, bits: int = 8, follow: bool = True) -> None:
    """Write CNN values as a picture; the name's ending is the format, ``follow`` as in `writing`.

    ``bits`` of a grey level: 8, 16 (PNG, TIFF), or 32, floats from 0 (black) to 1 (white) (TIFF). A .npy file holds the
    values themselves, also those beyond -1 and 1; a .npz file holds them as ``values``.

    Raises:
        InputError: an ending that Pillow does not know, a file that cannot be written, values that are not CNN values,
            bits that the format does not have.
    """
    check_bits(path, bits)
    if not is_whole(scale) or scale < 1:
        raise InputError(f"scale {scale!r}; a whole number of pixels a cell, at least 1, wanted")
    if not (isinstance(values, np.ndarray) and values.dtype == bool):
        values = as_numbers("picture", values)
    if values.ndim not in (2, 3):
        raise InputError(f"{path}: a picture of shape {values.shape}; (rows, cols) wanted")
    if not np.isfinite(largest(values)):
        raise InputError(f"{path}: a picture that holds {values[~np.isfinite(values)][0]}; finite numbers wanted")
    if values.size >= LARGE and (report := watcher()) is not None:
        report(None, f"writing {path}")
    with writing(path, follow=follow) as temporary:
        if temporary.suffix.lower() in ARRAY_ENDINGS:
            _write_array(values, temporary)
        else:
            (to_image(values, scale) if bits == 8 else _deep_image(values, bits, scale)).save(temporary)


def check_bits(path: str | Path, bits: int) -> None:
    """Check that a file can hold grey levels of ``bits`` bits.

    Raises:
        InputError: it cannot.
    """
    ending = named_file(path).suffix.lower()
    if bits != 8 and ending not in DEEP.get(bits, ()):
        known = "; ".join(f"{count}: {', '.join(endings)}" for count, endings in DEEP.items())
        raise InputError(f"{path}: {bits!r} bits a grey level; 8 wanted, or {known}; .npy holds the numbers themselves")


def _write_array(values: Array, path: Path) -> None:
    with path.open("wb") as file:
        if path.suffix.lower() == ".npz":
            np.savez(file, values=values)
        else:
            np.save(file, values)


def _deep_image(values: Array, bits: int, scale: int) -> Image.Image:
    """Return CNN values (rows, cols) as grey levels of 16 bits, or floats from 0 to 1; layers lie side by side."""
    values = np.concatenate(list(values), axis=1) if values.ndim == 3 else values
    values = np.where(values, 1.0, -1.0) if values.dtype == bool else values
    levels = np.kron((1.0 - np.clip(values, -1, 1)) / 2, np.ones((scale, scale)))
    return Image.fromarray(levels.astype(np.float32) if bits == 32 else np.rint(levels * 65535).astype(np.uint16))


def _cell(value: float) -> float:
    return (1.0 if value else -1.0) if isinstance(value, bool) else float(value)


def parse_ascii(rows: Iterable[str | Sequence[float]]) -> Floats:
    """Parse a picture in text: ``#`` is +1, ``.`` is -1; a row may also be a list of numbers, where True is black.

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
    """Return CNN values as text, one string per row, from ``.`` (white) to ``#`` (black)."""
    values = np.where(values, 1.0, -1.0) if values.dtype == bool else np.clip(values, -1, 1)
    level = np.rint((values + 1) / 2 * (len(_RAMP) - 1)).astype(int)
    return ["".join(_RAMP[cell] for cell in row) for row in level]
