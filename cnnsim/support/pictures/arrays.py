"""Arrays of NumPy files (.npy, .npz) read as pictures: booleans, grey levels, colours, or CNN values."""

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from cnnsim.support.bounds import check_unpacked, one_line
from cnnsim.support.errors import InputError
from cnnsim.support.memory import check_memory
from cnnsim.support.pictures.pixels import from_levels, labels_error, range_of, tell_if_dark
from cnnsim.support.pictures.sequence import PictureSequence, Reading
from cnnsim.support.types import Array


def of_array(path: Path, reading: Reading, key: str) -> PictureSequence:
    """Return the planes (rows, cols) or (n, rows, cols) of an .npy or .npz file, of the latter ``key`` or the only one.

    Booleans: True is black; whole numbers of 8 or 16 bits: grey levels; floats from -1 to 1: CNN values.

    Raises:
        InputError: no such file, no such array, another shape, numbers without a range, more than memory holds.
    """
    name, values = str(path), _loaded(path, key)
    if levels_wanted(values, reading):
        raise labels_error(name)
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
    least, most = float(values.min()), float(values.max())
    levels = reading.levels
    if levels is None and values.dtype == np.uint16:
        levels = 0.0, 65535.0
        tell_if_dark(name, most, levels)
    elif levels is None:
        levels = (1.0, -1.0) if -1 <= least <= most <= 1 else range_of(values, name)

    def plane(numbers: Array) -> Array:
        found = from_levels(numbers, name, levels, reading.dtype)
        return np.where(found > 0, 1.0, -1.0).astype(reading.dtype) if reading.binary else found

    return _of_planes(name, planes, plane)


def levels_wanted(values: Array, reading: Reading) -> bool:
    """Return whether whole numbers are only 0 and 1: grey levels, CNN values and labels look alike then."""
    if reading.levels is not None or values.dtype.kind not in "iu" or not values.size:
        return False
    return (int(values.min()), int(values.max())) == (0, 1)


def _of_planes(name: str, planes: Array, values: Callable[[Array], Array]) -> PictureSequence:
    shape = int(planes.shape[1]), int(planes.shape[2])
    return PictureSequence(name, shape, lambda: len(planes), lambda: map(values, planes))


def _loaded(path: Path, key: str) -> Array:
    with one_line(path, "an array of NumPy"):
        if not path.exists():
            raise InputError(f"no array file {path}")
        check_unpacked(path, _array_bytes(path))
        check_memory(f"{path}: reading it", _array_bytes(path), "give fewer or smaller pictures")
        found = np.load(path, allow_pickle=False)
        if isinstance(found, np.ndarray):
            return found
        with found:
            if key not in found and len(found.files) != 1:
                wanted = f"one called {key!r}, or a single one," if key else "a single one"
                raise InputError(f"{path} holds the arrays {', '.join(found.files)}; {wanted} wanted")
            return found[key if key in found else found.files[0]]


def _array_bytes(path: Path) -> int:
    """Return how large the arrays of a file are when they are unpacked."""
    if path.suffix.lower() == ".npy":
        return path.stat().st_size
    with zipfile.ZipFile(path) as archive:
        return max((item.file_size for item in archive.infolist()), default=0)
