"""Picture files read and written as CNN values."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from cnnsim.support.errors import InputError
from cnnsim.support.types import Array, Floats
from cnnsim.support.values import from_gray

_RAMP = ".:-=+*%#"
"""Characters from white to black."""


def read_picture(path: str | Path, *, binary: bool = False) -> Floats:
    """Read any picture Pillow knows as CNN values (rows, cols); colours become grey, transparency white.

    ``binary`` makes everything darker than mid-grey +1 and the rest -1.

    Raises:
        InputError: the file is missing or no picture.
    """
    try:
        with Image.open(path) as image:
            over_white = Image.new("RGBA", image.size, "white")
            over_white.alpha_composite(image.convert("RGBA"))
            grey = np.asarray(over_white.convert("L"), dtype=np.float64)
    except FileNotFoundError as error:
        raise InputError(f"no picture {path}") from error
    except (UnidentifiedImageError, OSError) as error:
        raise InputError(f"{path} is no picture that Pillow can read: {error}") from error
    values = from_gray(grey)
    return np.where(values > 0, 1.0, -1.0) if binary else values


def to_image(values: Array, scale: int = 1) -> Image.Image:
    """Return CNN values (rows, cols) as a grey picture, each cell ``scale`` pixels wide; booleans: True is black.

    Planes (layers, rows, cols) lie side by side.
    """
    values = np.concatenate(list(values), axis=1) if values.ndim == 3 else values
    values = np.where(values, 1.0, -1.0) if values.dtype == bool else np.clip(values, -1, 1)
    grey = np.rint((1.0 - values) * 127.5).astype(np.uint8)
    return Image.fromarray(np.kron(grey, np.ones((scale, scale), dtype=np.uint8)))


def write_picture(values: Array, path: str | Path, scale: int = 1) -> None:
    """Write CNN values as a picture; the format follows the name's ending.

    Raises:
        InputError: Pillow does not know the ending, or the file cannot be written.
    """
    try:
        to_image(values, scale).save(path)
    except (ValueError, OSError) as error:
        raise InputError(f"cannot write {path}: {getattr(error, 'strerror', None) or error}") from error


def write_film(frames: Sequence[Array], path: str | Path, seconds: float = 3.0) -> None:
    """Write CNN values over time as an animated GIF that runs for about ``seconds`` and then stands a second.

    Raises:
        InputError: another ending than .gif, or the file cannot be written.
    """
    if Path(path).suffix.lower() != ".gif":
        raise InputError(f"cannot write {path}: a film is an animated GIF, .gif wanted")
    scale = max(1, 256 // max(frames[0].shape))
    images = [to_image(frame, scale) for frame in frames]
    lasting = [max(20, round(1000 * seconds / len(images)))] * (len(images) - 1) + [1000]
    try:
        images[0].save(path, format="GIF", save_all=True, append_images=images[1:], duration=lasting, loop=0)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error


def parse_ascii(rows: Iterable[str | Sequence[float]]) -> Floats:
    """Read a picture drawn in text: ``#`` is +1, ``.`` is -1; a row of numbers stands for itself.

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
                values.append([float(value) for value in row])
            except (TypeError, ValueError, OverflowError) as error:
                raise InputError(f"row {number} of a picture is {row!r}; a text or a list of numbers wanted") from error
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
