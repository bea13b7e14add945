"""Pictures in NumPy files (.npy, .npz): arrays of booleans, grey levels, colours or CNN values."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.support.array_files import open_npz, read_array
from cnnsim.support.errors import InputError
from cnnsim.support.pictures.pixels import Levels, extremes, from_levels, labels_error, tell_if_dark
from cnnsim.support.pictures.sequence import PictureOptions, PictureSequence
from cnnsim.support.values import Array

SIXTEEN_BITS: Levels = (0.0, 65535.0)
"""Levels of whole numbers of 16 bits."""
CNN_VALUES: Levels = (1.0, -1.0)
"""Levels of floats."""
_BLOCK = 1 << 20
"""Numbers that are read at a time, at least a row."""


def of_array(path: Path, reading: PictureOptions, key: str) -> PictureSequence:
    """Return the planes of an .npy file, or of the array ``key`` (or the only one) of an .npz file, as a sequence.

    An array is (rows, cols) or (n, rows, cols), of colours (..., 3 or 4).

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
    """Refuse whole numbers that are only 0 and 1, because they may be grey levels, CNN values or labels.

    Zeros alone are refused except in unsigned numbers of 8 or 16 bits, where they are black grey levels. A stored array
    is read in blocks up to the first other number.

    Raises:
        InputError: all numbers are 0 or 1.
    """
    if values.dtype.kind not in "iu" or not values.ndim or 0 in values.shape:
        return
    found: set[int] = set()
    rows = max(1, _BLOCK // math.prod(values.shape[1:]))
    for first in range(0, values.shape[0], rows):
        part = np.asarray(values[first : first + rows])
        found |= {int(part.min()), int(part.max())}
        if not found <= {0, 1}:
            return
    if found == {0, 1} or (found == {0} and values.dtype not in (np.uint8, np.uint16)):
        raise labels_error(name, zeros=found == {0})


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
        if not isinstance(array, np.ndarray):  # NumPy returns bytes for a member that is no array
            raise ValueError(f"{key if key in found else found.files[0]} is no array")
        return array
