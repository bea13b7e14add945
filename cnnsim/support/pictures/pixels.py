"""Conversion of the pixels of a picture file to CNN values, by kind: bits, palette, colours, 16 bits, floats.

* 1 bit, 8 bit grey, palette, RGB, CMYK and the like: their grey level of 0 (black) to 255 (white);
* with transparency: over white;
* 16 bit grey: 0 to 65535 (a TIFF of 12 bits: 0 to 4095);
* floats: 0 (black) to 1 (white) if they lie in [0, 1]; CNN values, black 1, if they lie in [-1, 1];
* ``levels`` (black, white), if given, are the range of a grey picture; other ranges are an error.
"""

from typing import Any

import numpy as np
from PIL import Image

from cnnsim.support.errors import InputError, shown
from cnnsim.support.notices import Notices
from cnnsim.support.pictures.upright import upright
from cnnsim.support.values import Array, from_gray, is_number

Levels = tuple[float, float]
"""The numbers that stand for black and for white."""

_BITS_PER_SAMPLE, _PHOTOMETRIC, _WHITE_IS_ZERO = 258, 262, 0  # tags of TIFF
_SIXTEEN_BITS = 65535.0
_STRIP = 1 << 20
"""Pixels that are converted at a time, so that temporary arrays are small."""


def pixel_bytes(mode: str) -> int:
    """Return the bytes of temporary memory per pixel of a Pillow mode."""
    if mode in ("1", "L"):
        return 3  # the picture, its bytes, and the blocks these are joined from
    return 6 if mode.startswith("I;16") else 14


def check_labels(image: Image.Image, name: str, levels: Levels | None) -> None:
    """Refuse a grey picture that has the levels 0 and 1 alone, unless ``levels`` are given: both would be black.

    Raises:
        InputError: so it is.
    """
    if levels is None and image.mode == "L" and image.getextrema() == (0, 1):
        raise labels_error(name)


def labels_error(name: str, *, zeros: bool = False) -> InputError:
    """Return the error for whole numbers that are only 0 and 1, or, with ``zeros``, only 0."""
    held = "number 0 alone, black as a grey level" if zeros else "numbers 0 and 1 alone, as grey levels both black"
    return InputError(
        f"{name} holds the {held}; their meaning wanted: --range 1,0 (1 is black), 0,1 (1 is white), 0,255 (levels); "
        "in Python levels=(1, 0)"
    )


def tell_if_dark(name: str, most: float, levels: Levels | None) -> None:
    """Give a notice on a command line if 16-bit numbers use less than 1/16 of their range, as 12-bit numbers do.

    ``most`` is the largest number, ``levels`` the range that the file states.
    """
    dark = levels is not None and max(levels) == _SIXTEEN_BITS and 0 < most <= _SIXTEEN_BITS / 16
    if dark and Notices.tell is not None:
        top = 2 ** max(8, int(most).bit_length()) - 1
        said = f"{name}: its largest number is {most:g} of {_SIXTEEN_BITS:.0f}, so the picture is nearly black"
        Notices.once(f"{said}; if {top} is white, use --range 0,{top}")


def values_of(
    image: Image.Image, name: str, *, binary: bool = False, levels: Levels | None = None, dtype: Any = np.float64
) -> Array:
    """Return the CNN values (rows, cols) of a picture; ``binary`` makes darker than mid-grey +1 and the rest -1.

    Raises:
        InputError: numbers whose range is not known, or outside of the range given.
    """
    check_levels(image, name, levels)
    image = upright(image)
    if holds_numbers(image):
        values = _numbers(image, name, levels, dtype)
        if image.has_transparency_data and isinstance(clear := image.info["transparency"], int):
            values[np.asarray(image) == clear] = -1
        return _black_or_white(values) if binary else values
    if levels is not None:
        values = from_levels(np.asarray(image.convert("L")), name, levels, dtype)
        return _black_or_white(values) if binary else values
    return table_of(dtype, binary=binary)[np.asarray(grey_of(image))]


def holds_numbers(image: Image.Image) -> bool:
    """Return whether the pixels of a picture are numbers of 16 bits or more, or floats."""
    return image.mode.startswith("I;16") or image.mode in ("I", "F")


def check_reading(levels: Any, dtype: Any) -> None:
    """Check that ``levels`` are two numbers and that ``dtype`` is a type of floats.

    Raises:
        InputError: what was given.
    """
    pair = isinstance(levels, tuple | list) and len(levels) == 2 and all(map(is_number, levels))
    if levels is not None and not pair:
        raise InputError(f"levels {shown(levels)}; two numbers wanted, those of black and of white")
    try:
        floats = np.dtype(dtype).kind == "f"
    except TypeError:
        floats = False
    if not floats:
        raise InputError(f"dtype {shown(dtype)}; a type of floats wanted, such as float32")


def check_levels(image: Image.Image, name: str, levels: Levels | None) -> None:
    """Refuse a range of levels for a picture in colours, or with transparency.

    Raises:
        InputError: its mode.
    """
    if holds_numbers(image) or levels is None or (image.mode in ("1", "L") and not image.has_transparency_data):
        return
    raise InputError(f"{name} is a picture of mode {image.mode}; a range of levels goes with grey pictures")


def grey_of(image: Image.Image) -> Image.Image:
    """Return a picture of bytes, colours or a palette in grey levels, over white."""
    if image.has_transparency_data:
        return _over_white(image)
    return image if image.mode == "L" else image.convert("RGB").convert("L")


def table_of(dtype: Any, *, binary: bool) -> Array:
    """Return the CNN value of each of the 256 grey levels."""
    table = from_gray(np.arange(256))
    return (np.where(table > 0, 1.0, -1.0) if binary else table).astype(dtype)


def own_levels(image: Image.Image) -> Levels | None:
    """Return the levels that the format or the header of a picture of numbers states; None if there are none."""
    tags = getattr(image, "tag_v2", {})
    if not (image.mode.startswith("I;16") or image.format in ("PNG", "PPM")):
        return None
    top = float(2 ** int(tags.get(_BITS_PER_SAMPLE, (16,))[0]) - 1)
    return (top, 0.0) if tags.get(_PHOTOMETRIC) == _WHITE_IS_ZERO else (0.0, top)


def from_levels(numbers: Array, name: str, levels: Levels, dtype: Any = np.float64) -> Array:
    """Return numbers as CNN values: linear, with ``levels`` as black (+1) and white (-1).

    Raises:
        InputError: numbers outside that range, or a range of no length.
    """
    black, white = levels
    with np.errstate(all="ignore"):
        scale = 2.0 / (np.float64(white) - black)
    if not (np.isfinite(levels).all() and 0 < abs(scale) < np.inf):
        raise InputError(f"black is {black:g} and white {white:g}; two different numbers, of some size, wanted")
    least, most = extremes(numbers, name)
    if not min(levels) <= least <= most <= max(levels):
        raise InputError(f"{name} holds numbers from {least:g} to {most:g}; {black:g} (black) to {white:g} wanted")
    values = np.empty(numbers.shape, dtype)
    flat, source = values.reshape(-1), numbers.reshape(-1)
    for first in range(0, flat.size, _STRIP):
        part = source[first : first + _STRIP].astype(np.float64)
        flat[first : first + _STRIP] = 1.0 - (part - black) * scale
    return values


def extremes(numbers: Array, name: str) -> tuple[float, float]:
    """Return the minimum and the maximum of some numbers.

    Raises:
        InputError: one is not finite.
    """
    least, most = float(numbers.min()), float(numbers.max())
    if not np.isfinite(most - least):
        raise InputError(f"{name} holds {most if np.isfinite(least) else least:g}; finite numbers wanted")
    return least, most


def range_of(numbers: Array, name: str) -> Levels:
    """Return the levels of numbers by their range: grey levels in [0, 1], CNN values in [-1, 1].

    Raises:
        InputError: they are in neither.
    """
    least, most = extremes(numbers, name)
    if 0 <= least <= most <= 1:
        return 0.0, 1.0
    if -1 <= least <= most <= 1:
        return 1.0, -1.0
    raise InputError(
        f"{name} holds numbers from {least:g} to {most:g} and does not say which are black and white; 0 to 1 (grey), "
        "-1 to 1 (CNN values), or the range (--range BLACK,WHITE; levels=(black, white)) wanted"
    )


def check_whole(image: Image.Image, name: str, least: float, most: float) -> None:
    """Refuse whole numbers of 32 bits, whose format has no range.

    Raises:
        InputError: the picture has whole numbers of 32 bits.
    """
    if image.mode == "I":
        raise InputError(
            f"{name} holds whole numbers of 32 bits from {least:.0f} to {most:.0f} and does not say which are "
            "black and white; the range (--range BLACK,WHITE; levels=(black, white)) wanted"
        )


def _numbers(image: Image.Image, name: str, levels: Levels | None, dtype: Any) -> Array:
    numbers = np.asarray(image)
    if levels is None:
        levels = own_levels(image)
        tell_if_dark(name, float(numbers.max()), levels)
    if levels is None:
        check_whole(image, name, float(numbers.min()), float(numbers.max()))
    return from_levels(numbers, name, range_of(numbers, name) if levels is None else levels, dtype)


def _black_or_white(values: Array) -> Array:
    return np.where(values > 0, values.dtype.type(1), values.dtype.type(-1))


def _over_white(image: Image.Image) -> Image.Image:
    over_white = Image.new("RGBA", image.size, "white")
    over_white.alpha_composite(image.convert("RGBA"))
    return over_white.convert("L")
