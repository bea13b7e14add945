"""Pictures as planes of large grids: Zarr and .npy arrays are read in parts, other pictures are decoded whole."""

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.supersteps.store import zarr_library
from cnnsim.support import Array, InputError
from cnnsim.support.array_files import mapped_array
from cnnsim.support.command_files import note_read
from cnnsim.support.files import writing
from cnnsim.support.limits import one_line
from cnnsim.support.memory import check_memory
from cnnsim.support.pictures.arrays import cnn_values, of_array
from cnnsim.support.pictures.picture import to_image
from cnnsim.support.pictures.pixels import Levels
from cnnsim.support.pictures.read import read_picture
from cnnsim.support.pictures.sequence import PictureOptions

ROWS = 1024
"""Rows that are written at a time."""


def open_large(path: Path, *, binary: bool = False, levels: Levels | None = None) -> Any:
    """Return a picture as a plane, with ``levels`` (black, white) as in `read_picture`.

    Zarr arrays and .npy files of floats, read as CNN values, stay on the disk; other pictures are decoded into memory.

    Raises:
        InputError: as `read_picture`; a Zarr array of other numbers than floats or booleans.
    """
    plain = not binary and levels is None
    if path.is_dir():
        zarr = zarr_library()
        note_read(path)
        with one_line(path, "a Zarr array"):
            found = zarr.open_array(path, mode="r")
        _check_plane(found, path, "bf" if plain else "")
        return found
    if path.suffix.lower() not in (".npy", ".npz"):
        return read_picture(path, binary=binary, levels=levels, dtype=np.float32)
    if path.suffix.lower() == ".npy":
        mapped = mapped_array(path)
        _check_plane(mapped, path, "bfui")
        if plain and mapped.dtype.kind == "f":
            cnn_values(mapped, str(path))
            return mapped
    planes = of_array(path, PictureOptions(binary, levels, np.float32), "")
    if planes.count() != 1:
        raise InputError(f"{path} holds {planes.count()} pictures; one wanted")
    return next(planes.pictures())


def _check_plane(plane: Any, path: Path, kinds: str) -> None:
    if len(plane.shape) != 2 or 0 in plane.shape or np.dtype(plane.dtype).kind not in kinds:
        wanted = "floats, levels or booleans" if "u" in kinds else "floats or booleans, without --binary or --range,"
        raise InputError(f"{path}: {plane.dtype} of shape {plane.shape}; (rows, cols) of {wanted} wanted")


def write_large(plane: Any, path: Path, *, follow: bool = True) -> None:
    """Write the outputs of a state on the disk as a picture: .npy in parts, others whole; ``follow`` as in `writing`.

    Raises:
        InputError: planes of several grids or layers, an unknown ending, not enough memory for the picture.
    """
    if len(plane.shape) != 2:
        raise InputError(f"a result of shape {plane.shape} as a picture; (rows, cols) wanted")
    rows, cols = plane.shape
    with writing(path, follow=follow) as temporary:
        if path.suffix.lower() == ".npy":
            out: Any = np.lib.format.open_memmap(temporary, "w+", np.float32, (rows, cols))
        else:
            check_memory(f"{path}: {rows} x {cols} pixels", 2 * rows * cols, "a .npy file wanted")
            out = np.empty((rows, cols), np.uint8)
        for row in range(0, rows, ROWS):
            y = _outputs(np.asarray(plane[row : row + ROWS]))
            out[row : row + len(y)] = y if out.dtype == np.float32 else np.asarray(to_image(y))
        if out.dtype == np.uint8:
            Image.fromarray(out).save(temporary)


def _outputs(x: Array) -> Array:
    return np.where(x, np.float32(1), np.float32(-1)) if x.dtype == bool else np.clip(x, -1, 1)
