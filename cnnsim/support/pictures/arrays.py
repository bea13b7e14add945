"""Arrays of NumPy files (.npy, .npz) read as pictures: booleans, grey levels, colours, or CNN values."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.support.array_files import open_npz, read_array
from cnnsim.support.errors import InputError
from cnnsim.support.pictures.pixels import Levels, extremes, from_levels, labels_error, tell_if_dark
from cnnsim.support.pictures.sequence import PictureSequence, Reading
from cnnsim.support.types import Array

SIXTEEN_BITS: Levels = (0.0, 65535.0)
"""Levels of whole numbers of 16 bits."""
CNN_VALUES: Levels = (1.0, -1.0)
"""Levels of floats."""
_BLOCK, _BLOCKS = 1 << 20, 512
"""Numbers that are looked at before the next are read, and how often at most: of arrays on the disk that are larger
than that, blocks spread over all of them."""


def of_array(path: Path, reading: Reading, key: str) -> PictureSequence:
    """Return the planes (rows, cols) or (n, rows, cols) of an .npy or .npz file, of the latter ``key`` or the only one.

    Booleans: True is black; whole numbers of 8 or 16 bits: grey levels; floats from -1 to 1: CNN values.

    Raises:
        InputError: no such file, no such array, another shape, numbers without a range, more than memory holds.
    """
    name, values = str(path), _loaded(path, key)
    if reading.levels is None:
        check_array_levels(values, name)
    colours = values.dtype == np.uint8 and values.ndim in (3, 4) and values.shape[-1] in (3, 4)
    planes = values if values.ndim == 3 + colours else values[None]
    if planes.ndim != 3 + colours or not planes.size:
        raise InputError(f"{name} holds an array of shape {values.shape}; (rows, cols) or (n, rows, cols) wanted")
    if colours or values.dtype == np.uint8:
        return _of_planes(name, planes, lambda plane: reading.values(Image.fromarray(plane), name))
    if values.dtype == bool:
        return _of_planes(name, planes, lambda plane: np.where(plane, 1.0, -1.0).astype(reading.dtype))
    if values.dtype.kind not in "iuf":
        raise InputError(f"{name} holds {values.dtype}; numbers, or True for black, wanted")
    levels = reading.levels
    if levels is None and values.dtype == np.uint16:
        levels = SIXTEEN_BITS
        tell_if_dark(name, float(values.max()), levels)
    elif levels is None:
        levels = cnn_values(values, name)

    def plane(numbers: Array) -> Array:
        found = from_levels(numbers, name, levels, reading.dtype)
        return np.where(found > 0, 1.0, -1.0).astype(reading.dtype) if reading.binary else found

    return _of_planes(name, planes, plane)


def check_array_levels(values: Any, name: str) -> None:
    """Refuse whole numbers that are only 0 and 1: grey levels, CNN values and labels look alike then.

    So do zeros alone, but for bytes and 16 bits without a sign: they are grey levels, and that is black. Parts are read
    up to the first other number.

    Raises:
        InputError: so they are.
    """
    if values.dtype.kind not in "iu" or not values.ndim or 0 in values.shape:
        return
    found: set[int] = set()
    for part in _parts(values):
        found |= {int(part.min()), int(part.max())}
        if not found <= {0, 1}:
            return
    if found == {0, 1} or (found == {0} and values.dtype not in (np.uint8, np.uint16)):
        raise labels_error(name, zeros=found == {0})


def _parts(values: Any) -> Iterator[Array]:
    """Yield an array part by part: chunks as they are stored, else blocks of rows."""
    chunks = getattr(values, "chunks", None) or (max(1, _BLOCK // math.prod(values.shape[1:])), *values.shape[1:])
    counts = [-(-size // chunk) for size, chunk in zip(values.shape, chunks, strict=True)]
    total = math.prod(counts)
    for number in range(min(total, _BLOCKS)):
        at, rest = [], number * total // min(total, _BLOCKS)
        for count in reversed(counts):
            rest, place = divmod(rest, count)
            at.append(place)
        yield np.asarray(
            values[tuple(slice(k * size, (k + 1) * size) for k, size in zip(at[::-1], chunks, strict=True))]
        )


def cnn_values(values: Array, name: str) -> Levels:
    """Return the levels of numbers that are CNN values.

    Raises:
        InputError: they are not from -1 to 1, or not finite.
    """
    least, most = extremes(values, name)
    if -1 <= least <= most <= 1:
        return CNN_VALUES
    raise InputError(
        f"{name} holds {values.dtype} numbers from {least:g} to {most:g} and does not say which are black and white; "
        "-1 (white) to 1 (black), or the range (--range BLACK,WHITE; levels=(black, white)) wanted"
    )


def _of_planes(name: str, planes: Array, values: Callable[[Array], Array]) -> PictureSequence:
    shape = int(planes.shape[1]), int(planes.shape[2])
    return PictureSequence(name, shape, lambda: len(planes), lambda: map(values, planes))


def _loaded(path: Path, key: str) -> Array:
    if not path.exists():
        raise InputError(f"no array file {path}")
    if path.suffix.lower() == ".npy":
        return read_array(path)
    with open_npz(path, "array of pictures") as found:
        if key not in found and len(found.files) != 1:
            wanted = f"one called {key!r}, or a single one," if key else "a single one"
            raise InputError(f"{path} holds the arrays {', '.join(found.files)}; {wanted} wanted")
        array = found[key if key in found else found.files[0]]
        if not isinstance(array, np.ndarray):  # NumPy gives out bytes of what does not begin as an array
            raise ValueError(f"{key if key in found else found.files[0]} is no array")
        return array
