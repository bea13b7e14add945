"""Planes that lie on the disk written as pictures, strip by strip."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.supersteps.strips import image_library
from cnnsim.support import Array, InputError
from cnnsim.support.files import writing
from cnnsim.support.memory import check_memory
from cnnsim.support.progress import watcher

MOST = 1 << 24
"""Cells of a strip that is written at a time, and up to which a picture is made whole."""
IN_STRIPS = ".png", ".tif", ".tiff"
"""Names of pictures that are written in strips above it."""
_CLASSIC = 1 << 31
"""Bytes from which on a TIFF counts its bytes with 64 bits: those that lie behind 4 GiB have no place in the others."""

_Put = Callable[[int, Array], None]
"""Takes the first row of a strip, and its outputs."""


def write_large(plane: Any, path: Path, *, follow: bool = True) -> None:
    """Write the outputs of a state that lies on the disk, strip by strip: .npy, .pgm, PNG, TIFF; others whole.

    ``follow`` as in `writing`.

    Raises:
        InputError: planes of several grids or layers, an ending that nobody knows, OpenImageIO is missing for a large
            PNG or TIFF, a picture of another kind that does not fit into memory.
    """
    if len(plane.shape) != 2:
        raise InputError(f"a result of shape {plane.shape} as a picture; (rows, cols) wanted")
    rows, cols = plane.shape
    strip = max(1, MOST // cols)
    with writing(path, follow=follow) as beside, _way(beside, rows, cols)(beside, rows, cols) as put:
        for r0 in range(0, rows, strip):
            if (told := watcher()) is not None:
                told(r0 / rows, f"writing {path.name}")
            put(r0, np.clip(np.asarray(plane[r0 : r0 + strip]), -1.0, 1.0))


def _way(path: Path, rows: int, cols: int) -> Any:
    suffix = path.suffix.lower()
    if suffix in (".npy", ".pgm"):
        return _numpy if suffix == ".npy" else _pgm
    return _strips if suffix in IN_STRIPS and rows * cols > MOST else _whole


@contextmanager
def _numpy(path: Path, rows: int, cols: int) -> Iterator[_Put]:
    out = np.lib.format.open_memmap(path, "w+", np.float32, (rows, cols))

    def put(r0: int, y: Array) -> None:
        out[r0 : r0 + len(y)] = y

    yield put
    out.flush()


@contextmanager
def _pgm(path: Path, rows: int, cols: int) -> Iterator[_Put]:
    with path.open("wb") as file:
        file.write(f"P5\n{cols} {rows}\n255\n".encode())
        yield lambda _, y: _written(file.write(_grey(y).tobytes()))


@contextmanager
def _whole(path: Path, rows: int, cols: int) -> Iterator[_Put]:
    check_memory(f"{path}: {rows} x {cols} pixels at once", 2 * rows * cols, "PNG, TIFF, .pgm or .npy wanted")
    grey = np.empty((rows, cols), np.uint8)

    def put(r0: int, y: Array) -> None:
        grey[r0 : r0 + len(y)] = _grey(y)

    yield put
    Image.fromarray(grey).save(path)


@contextmanager
def _strips(path: Path, rows: int, cols: int) -> Iterator[_Put]:
    library = image_library(path)
    spec = library.ImageSpec(cols, rows, 1, "uint8")
    spec.attribute("tiff:bigtiff", int(rows * cols >= _CLASSIC))
    out = library.ImageOutput.create(str(path))

    def check(done: bool) -> None:
        if not done:
            raise OSError(f"cannot write {path}: {out.geterror().strip()}")

    check(out.open(str(path), spec))
    try:
        yield lambda r0, y: check(out.write_scanlines(r0, r0 + len(y), 0, _grey(y)[..., None]))
    finally:
        closed = out.close()
    check(closed)


def _written(_: int) -> None:
    """Take how much was written: all, or an error was raised."""


def _grey(y: Array) -> Array:
    return np.rint((1.0 - y) * 127.5).astype(np.uint8)
