"""Large pictures as planes that are read part by part: rows and columns become CNN values when they are asked for."""

from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.supersteps.store import zarr_library
from cnnsim.supersteps.strips import FileRows
from cnnsim.support import Array, InputError
from cnnsim.support.array_files import mapped_array
from cnnsim.support.limits import one_line
from cnnsim.support.pictures.arrays import CNN_VALUES, check_array_levels, cnn_values
from cnnsim.support.pictures.picture import check_size, opened, pictures_in
from cnnsim.support.pictures.pixels import (
    Levels,
    check_labels,
    from_levels,
    grey_of,
    holds_numbers,
    table_of,
    values_of,
)
from cnnsim.support.pictures.upright import upright, upright_size
from cnnsim.support.values import from_gray

WHOLE = 1 << 24
"""Pixels up to which a PNG or TIFF is decoded whole."""
IN_STRIPS = "PNG", "TIFF"
"""Formats that are decoded strip by strip above it."""


class TiledPicture:
    """A plane (rows, cols) of CNN values over the numbers of a file; a part is read, and converted, when asked for.

    ``levels`` are booleans (True is black), whole numbers as grey levels, or floats as CNN values, unless ``between``
    says which numbers are black and white.
    """

    in_parts = True

    def __init__(self, levels: Any, *, binary: bool, between: Levels | None = None, name: str = "a picture") -> None:
        self._levels, self._binary, self._between, self._name = levels, binary, between, name
        self.shape: tuple[int, int] = levels.shape
        self.dtype = np.dtype(np.float32)

    def __getitem__(self, part: Any) -> Array:
        found = np.asarray(self._levels[part])
        if found.dtype == bool:
            return np.where(found, np.float32(1), np.float32(-1))
        if self._between is CNN_VALUES:
            cnn_values(found, self._name)
            values = found
        elif self._between is not None:
            values = from_levels(found, self._name, self._between, np.float32)
        elif found.dtype == np.uint8:
            return table_of(np.float32, binary=self._binary)[found]
        else:
            values = found if found.dtype.kind == "f" else from_gray(found, float(np.iinfo(found.dtype).max))
        return np.where(values > 0, np.float32(1), np.float32(-1)) if self._binary else values.astype(np.float32)

    def told(self) -> bytes | None:
        """Return what tells this picture from others without reading its pixels, None if only they can."""
        if not isinstance(self._levels, FileRows):
            return None
        return repr((self.shape, self._binary, self._between)).encode() + self._levels.told()


def open_large(path: Path, *, binary: bool = False, levels: Levels | None = None) -> Any:
    """Return a picture as a plane that is read in parts, with ``levels`` (black, white) as in `read_picture`.

    .zarr, .npy and .pgm are read where they are; PNG and TIFF in strips (`strips.FileRows`); others are decoded whole,
    and are then a byte a pixel (two of 16 bits, four of floats). A Zarr array of floats is returned as it is: CNN
    values.

    Raises:
        InputError: no such picture, or none in two dimensions; as `read_picture`, of an array's values when they are
            read.
    """
    if path.is_dir():
        zarr = zarr_library()
        with one_line(path, "a Zarr array"):
            found = zarr.open_array(path, mode="r")
    elif path.suffix.lower() == ".npy":
        found = mapped_array(path)
    elif path.suffix.lower() == ".npz":
        raise InputError(f"{path}: packed arrays, on an engine; a plane that is read in parts, .npy or .zarr, wanted")
    else:
        return _picture(path, binary=binary, levels=levels)
    kind = np.dtype(found.dtype).kind
    if len(found.shape) != 2 or 0 in found.shape or kind not in "bfui":
        raise InputError(
            f"{path}: {found.dtype} of shape {found.shape}; (rows, cols) of floats, levels or truth wanted"
        )
    if path.is_dir() and kind == "f" and not binary and levels is None:
        return found
    if levels is None:
        check_array_levels(found, str(path))
        if kind == "i" or (kind == "u" and found.dtype.itemsize > 2) or (kind == "f" and not path.is_dir()):
            levels = CNN_VALUES
    return TiledPicture(found, binary=binary, between=levels, name=str(path))


def _picture(path: Path, *, binary: bool, levels: Levels | None) -> TiledPicture:
    """Return a picture: mapped into memory where the file has it as it is, else in strips, else decoded whole."""
    with opened(path) as image:
        rows, cols = upright_size(image)
        if pictures_in(image) > 1:
            raise InputError(f"{path} holds {pictures_in(image)} pictures; one wanted")
        if image.format in IN_STRIPS and rows * cols > WHOLE:
            strips = FileRows(path, levels)
            return TiledPicture(strips, binary=binary, between=strips.levels, name=str(path))
        tiles: Any = getattr(image, "tile", ())  # where the pixels lie in the file
        tile = tiles[0] if len(tiles) == 1 else None
        if image.format == "PPM" and image.mode == "L" and tile is not None and tile[0] == "raw":
            found: Any = np.memmap(path, np.uint8, "r", tile[2], (rows, cols))
            return TiledPicture(found, binary=binary, between=levels, name=str(path))
        check_size(image, str(path), 4)
        check_labels(image, str(path), levels)
        if holds_numbers(image) or levels is not None:
            return TiledPicture(values_of(image, str(path), levels=levels, dtype=np.float32), binary=binary)
        return TiledPicture(np.asarray(grey_of(upright(image))), binary=binary)
