"""PictureSequence: the pictures of a file that Pillow reads, or of a video, read one after the other."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cnnsim.support.errors import InputError
from cnnsim.support.limits import PAGES, check_plain, check_unpacked, one_line
from cnnsim.support.memory import check_memory
from cnnsim.support.pictures.film import video_library
from cnnsim.support.pictures.picture import check_size, opened, pictures_in
from cnnsim.support.pictures.pixels import Levels, check_labels, values_of
from cnnsim.support.pictures.upright import upright_size
from cnnsim.support.values import Array


@dataclass(frozen=True)
class PictureOptions:
    """Options of the conversion to CNN values, as in `cnnsim.read_picture`."""

    binary: bool = False
    levels: Levels | None = None
    dtype: Any = np.float64

    def values(self, image: Image.Image, name: str) -> Array:
        """Return the CNN values of a picture."""
        return values_of(image, name, binary=self.binary, levels=self.levels, dtype=self.dtype)


@dataclass(frozen=True)
class PictureSequence:
    """Pictures of one ``shape`` (rows, cols); ``pictures()`` reads them one by one, ``rate`` is per second, or None.

    ``count()`` is their number; for a ``long`` sequence, a video, it decodes the whole file.
    """

    name: str
    shape: tuple[int, int]
    count: Callable[[], int]
    pictures: Callable[[], Iterator[Array]]
    rate: float | None = None
    long: bool = False


def of_file(path: Path, reading: PictureOptions) -> PictureSequence:
    """Return the picture or pictures of a file that Pillow reads.

    Raises:
        InputError: no picture, one that does not fit into memory, or pictures of different sizes.
    """
    with opened(path) as image:
        check_size(image, str(path), np.dtype(reading.dtype).itemsize)
        count, (rows, cols) = pictures_in(image), upright_size(image)
        if count > 1:
            check_unpacked(path, count * rows * cols, PAGES)
        for number in range(1, count):
            image.seek(number)
            if (other := upright_size(image)) != (rows, cols):
                raise InputError(
                    f"pictures of different sizes: {path} begins with {size_text((rows, cols))}, its "
                    f"picture {number} is {size_text(other)}"
                )
        lasting = image.info.get("duration", 0)

    def pictures() -> Iterator[Array]:
        with opened(path) as image:
            for number in range(count):
                if count > 1:
                    image.seek(number)
                else:
                    check_labels(image, str(path), reading.levels)
                yield reading.values(image, str(path))

    rate = 1000 / lasting if count > 1 and lasting else None
    return PictureSequence(str(path), (rows, cols), lambda: count, pictures, rate)


def of_video(path: Path, reading: PictureOptions) -> PictureSequence:
    """Return the pictures of a video.

    Raises:
        InputError: no such file, PyAV is not installed or cannot read it.
    """
    if not path.exists():
        raise InputError(f"no video {path}")
    check_plain(path, "video")
    av = video_library(path)

    def decoded() -> Iterator[Any]:
        with one_line(path, "a video"), av.open(str(path), metadata_errors="replace") as container:
            if not container.streams.video:
                raise InputError(f"{path} holds no pictures; a video wanted")
            for frame in container.decode(video=0):
                size = frame.height * frame.width * (3 + np.dtype(reading.dtype).itemsize)
                check_memory(f"{path}: a picture of {frame.height} x {frame.width}", size, "give a smaller one")
                yield frame

    def pictures() -> Iterator[Array]:
        for frame in decoded():
            if (frame.height, frame.width) != shape:
                other = size_text((frame.height, frame.width))
                raise InputError(f"pictures of different sizes: {path} begins with {size_text(shape)}, one is {other}")
            yield reading.values(Image.fromarray(frame.to_ndarray(format="gray")), str(path))

    first = next(decoded(), None)
    if first is None:
        raise InputError(f"{path} holds no pictures; a video wanted")
    shape = int(first.height), int(first.width)
    with one_line(path, "a video"), av.open(str(path), metadata_errors="replace") as container:
        rate = container.streams.video[0].average_rate
    return PictureSequence(
        str(path), shape, lambda: sum(1 for _ in decoded()), pictures, float(rate or 0) or None,
        long=True,
    )  # fmt: skip


def size_text(shape: tuple[int, int]) -> str:
    """Return "rows x cols" for messages."""
    return f"{shape[0]} x {shape[1]}"
