"""Rows of a PNG or TIFF of any size, decoded strip by strip by OpenImageIO: such a file is never read whole."""

from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.support import Array, InputError
from cnnsim.support.extras import install_line
from cnnsim.support.memory import check_memory
from cnnsim.support.pictures.picture import opened, pictures_in
from cnnsim.support.pictures.pixels import (
    Levels,
    check_levels,
    check_whole,
    grey_of,
    holds_numbers,
    own_levels,
    range_of,
)
from cnnsim.support.pictures.upright import orientation
from cnnsim.support.progress import watcher

MOST = 1 << 22
"""Pixels of a strip that is worked on at a time."""
_RAW = "CMYK", "YCbCr"
"""Colours that Pillow makes grey, as elsewhere; the others come as red, green and blue."""


def image_library(path: Path) -> Any:
    """Return OpenImageIO.

    Raises:
        InputError: it is missing.
    """
    try:
        import OpenImageIO  # heavy, and of an extra
    except ImportError as error:
        raise InputError(
            f"{path}: OpenImageIO reads and writes PNG and TIFF of this size, and is missing: {install_line('scale')}; "
            ".npy, .pgm and .zarr go without it"
        ) from error
    OpenImageIO.attribute("limits:imagesize_MB", 0)  # a limit for whoever reads a picture whole
    return OpenImageIO


class FileRows:
    """The pixels (rows, cols) of a file: grey levels as bytes, or the numbers of a picture of 16 bits or floats.

    ``levels`` (black, white) are those of the numbers, None for bytes of 0 (black) to 255. Palettes of TIFF may be one
    grey level off what Pillow makes of them. Of a part of some columns all columns are kept, as the next part is often
    beside it: a byte a pixel, two of 16 bits, four of floats.

    Raises:
        InputError: a picture of several pages; a range that is not known, or that does not go with it; an interlaced
            PNG, which is decoded whole, that does not fit; what cannot be decoded.
    """

    def __init__(self, path: Path, levels: Levels | None = None) -> None:
        self._path, self._library = path, image_library(path)
        with opened(path) as image:
            if pictures_in(image) > 1:
                raise InputError(f"{path} holds {pictures_in(image)} pictures; one wanted")
            if (turned := orientation(image)) != 1:
                raise InputError(f"{path}: of EXIF orientation {turned}, and read in strips; an upright picture wanted")
            check_levels(image, str(path), levels)
            self._mode, self._numbers = image.mode, holds_numbers(image)
            self.shape = image.size[1], image.size[0]
            self._input, self._channels = self._begun()
            self._range(image, levels)
            if image.info.get("interlace"):
                size = self.shape[0] * self.shape[1] * self._channels * self.dtype.itemsize
                check_memory(f"{path}: an interlaced PNG", size, "save it without interlacing")
        self._kept: tuple[int, int, Array] | None = None

    def _begun(self) -> tuple[Any, int]:
        hints = self._library.ImageSpec()
        hints.attribute("oiio:UnassociatedAlpha", 1)
        hints.attribute("oiio:RawColor", int(self._mode in _RAW))
        found = self._library.ImageInput.open(str(self._path), hints)
        if found is None:
            raise InputError(f"{self._path} cannot be decoded: {self._library.geterror()}")
        spec = found.spec()
        self._tile = spec.tile_height
        bits = spec.get_int_attribute("oiio:BitsPerSample") or 8 * spec.format.size()
        self._shift = 8 * spec.format.size() - bits if self._numbers and bits < 8 * spec.format.size() else 0
        self.dtype = np.dtype(str(spec.format).replace("float", "float32")) if self._numbers else np.dtype(np.uint8)
        return found, spec.nchannels

    def _range(self, image: Image.Image, levels: Levels | None) -> None:
        """Find which numbers are black and white, as `pixels` does: those of floats after a look at all."""
        self.levels = levels
        if not self._numbers or levels is not None:
            return
        self.levels = own_levels(image)
        if self.levels is None:
            ends = np.array([(strip.min(), strip.max()) for strip in self._strips()])
            check_whole(image, str(self._path), ends.min(), ends.max())
            self.levels = range_of(ends, str(self._path))

    def _strips(self) -> Iterator[Array]:
        rows, step = self.shape[0], max(1, MOST // self.shape[1])
        for first in range(0, rows, step):
            if (told := watcher()) is not None:
                told(first / rows, f"the range of {self._path.name}")
            yield self._read(first, min(first + step, rows))

    def told(self) -> bytes:
        """Return what tells these pixels from others: the checksum of the file."""
        summed = sha256()
        with self._path.open("rb") as file:
            while piece := file.read(1 << 20):
                summed.update(piece)
        return summed.digest()

    def __getitem__(self, part: Any) -> Array:
        rows, cols = _spans(part, self.shape)
        if self._kept is not None and self._kept[0] <= rows[0] and rows[1] <= self._kept[1]:
            first, _, found = self._kept
            return found[rows[0] - first : rows[1] - first, cols[0] : cols[1]]
        self._kept = None  # gone before the next is read
        found = self._read(*rows)
        if cols[1] - cols[0] < self.shape[1]:
            self._kept = (*rows, found)
        return found[:, cols[0] : cols[1]]

    def _read(self, first: int, after: int) -> Array:
        """Return rows, decoded in strips; those of a file in tiles begin where a row of tiles does."""
        out = np.empty((after - first, self.shape[1]), self.dtype)
        high = max(self._tile, 1)
        step = max(1, MOST // self.shape[1] // high) * high
        for row in range(first // high * high, after, step):
            end = min(row + step, -(-after // high) * high, self.shape[0])
            strip = self._pixels(row, end)
            low, top = max(row, first), min(end, after)
            out[low - first : top - first] = self._levels(strip[low - row : top - row])
        return out

    def _pixels(self, first: int, after: int) -> Array:
        kind, cols = self._library.UNKNOWN, self.shape[1]
        if self._tile:
            found = self._input.read_tiles(0, 0, 0, cols, first, after, 0, 1, 0, self._channels, kind)
        else:
            found = self._input.read_scanlines(0, 0, first, after, 0, 0, self._channels, kind)
        if found is None or (said := self._input.geterror()):
            why = said if found is not None else self._input.geterror()
            raise InputError(f"{self._path} cannot be decoded from row {first} on: {why.strip()}")
        return found

    def _levels(self, pixels: Array) -> Array:
        if self._numbers:
            numbers = pixels[..., 0] >> self._shift if self._shift else pixels[..., 0]
            if self._channels == 2 and self.levels is not None:  # numbers that stand for nothing are white
                numbers = np.where(pixels[..., 1] == 0, numbers.dtype.type(self.levels[1]), numbers)
            return numbers
        if pixels.dtype == np.uint16:
            pixels = (pixels >> 8).astype(np.uint8)  # as Pillow does
        if self._channels == 1:
            return pixels[..., 0]
        return np.asarray(grey_of(self._image(pixels)))

    def _image(self, pixels: Array) -> Image.Image:
        mode = self._mode if self._mode in _RAW else {2: "LA", 3: "RGB", 4: "RGBA"}.get(self._channels)
        if mode is None:
            raise InputError(f"{self._path} has {self._channels} channels; grey, or red, green and blue, wanted")
        rows, cols = pixels.shape[:2]
        return Image.frombytes(mode, (cols, rows), np.ascontiguousarray(pixels).tobytes())


def _spans(part: Any, shape: tuple[int, int]) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the rows and columns [first, after) of an index of slices."""
    given = [one for one in (part if isinstance(part, tuple) else (part,)) if one is not Ellipsis]
    rows, cols = (
        one.indices(cells)[:2] for one, cells in zip([*given, slice(None), slice(None)][:2], shape, strict=True)
    )
    return rows, cols
