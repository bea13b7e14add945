"""Large pictures as planes that are read part by part: rows and columns become CNN values when they are asked for."""

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.supersteps.store import zarr_library
from cnnsim.support import Array, InputError
from cnnsim.support.files import writing
from cnnsim.support.pictures.picture import opened
from cnnsim.support.values import from_gray

MOST = 1 << 24
"""Cells of a strip that is converted at a time."""


class TiledPicture:
    """A plane (rows, cols) of CNN values over the numbers of a file; a part is read, and converted, when asked for."""

    def __init__(self, levels: Any, *, binary: bool) -> None:
        self._levels, self._binary = levels, binary
        self.shape: tuple[int, int] = levels.shape
        self.dtype = np.dtype(np.float32)

    def __getitem__(self, part: Any) -> Array:
        found = np.asarray(self._levels[part])
        if found.dtype == bool:
            return np.where(found, np.float32(1), np.float32(-1))
        values = found if found.dtype.kind == "f" else from_gray(found, float(np.iinfo(found.dtype).max))
        return np.where(values > 0, np.float32(1), np.float32(-1)) if self._binary else values.astype(np.float32)


def open_large(path: Path, *, binary: bool = False) -> Any:
    """Return a picture as a plane that is read in parts: .zarr, .npy, .pgm are never read whole, others as bytes.

    A Zarr array of floats is returned as it is: CNN values.

    Raises:
        InputError: no such picture, or none in two dimensions.
    """
    if path.is_dir():
        zarr = zarr_library()
        try:
            levels = zarr.open_array(path, mode="r")
        except (OSError, ValueError, KeyError) as error:
            raise InputError(f"{path}: no Zarr array; one, or a picture, wanted") from error
    elif path.suffix == ".npy":
        try:
            levels = np.load(path, mmap_mode="r")
        except (OSError, ValueError) as error:
            raise InputError(f"{path}: cannot be read as an array: {error}") from error
    else:
        levels = _levels(path)
    if len(levels.shape) != 2 or 0 in levels.shape or np.dtype(levels.dtype).kind not in "bfu":
        raise InputError(
            f"{path}: {levels.dtype} of shape {levels.shape}; (rows, cols) of floats, levels or truth wanted"
        )
    floats = np.dtype(levels.dtype).kind == "f"
    return levels if path.is_dir() and floats and not binary else TiledPicture(levels, binary=binary)


def _levels(path: Path) -> Any:
    """Return the grey levels of a picture: mapped into memory where the file has them as they are, else a byte each."""
    with opened(path) as image:
        tiles: Any = getattr(image, "tile", ())  # where the pixels lie in the file
        tile = tiles[0] if len(tiles) == 1 else None
        if image.format == "PPM" and image.mode == "L" and tile is not None and tile[0] == "raw":
            return np.memmap(path, np.uint8, "r", tile[2], (image.size[1], image.size[0]))
        return np.asarray(image if image.mode in ("1", "L") else _grey(image))


def _grey(image: Image.Image) -> Image.Image:
    if image.mode.startswith("I;16") or image.mode in ("I", "F"):
        raise InputError(f"a large picture of mode {image.mode}; 8 bits, .npy or .zarr wanted")
    return image.convert("RGB").convert("L")


def write_large(plane: Any, path: Path) -> None:
    """Write the outputs of a state that lies on the disk, strip by strip: as .npy, .pgm, or any picture Pillow writes.

    Raises:
        InputError: planes of several grids or layers, an ending that nobody knows.
    """
    if len(plane.shape) != 2:
        raise InputError(f"a result of shape {plane.shape} as a picture; (rows, cols) wanted")
    rows, cols = plane.shape
    strip = max(1, MOST // cols)
    parts = ((r0, np.clip(np.asarray(plane[r0 : r0 + strip]), -1.0, 1.0)) for r0 in range(0, rows, strip))
    with writing(path) as beside:
        if path.suffix == ".npy":
            out = np.lib.format.open_memmap(beside, "w+", np.float32, (rows, cols))
            for r0, y in parts:
                out[r0 : r0 + strip] = y
            out.flush()
        elif path.suffix == ".pgm":
            with beside.open("wb") as file:
                file.write(f"P5\n{cols} {rows}\n255\n".encode())
                for _, y in parts:
                    file.write(_bytes(y))
        else:
            grey = np.empty((rows, cols), np.uint8)
            for r0, y in parts:
                grey[r0 : r0 + strip] = np.frombuffer(_bytes(y), np.uint8).reshape(y.shape)
            Image.fromarray(grey).save(beside)


def _bytes(y: Array) -> bytes:
    return np.rint((1.0 - y) * 127.5).astype(np.uint8).tobytes()
