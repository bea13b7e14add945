"""Films of CNN values over time, written picture by picture: animated GIF, or video (MP4 and others, with PyAV)."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from cnnsim.support.errors import InputError
from cnnsim.support.extras import install_line
from cnnsim.support.files import writing
from cnnsim.support.pictures.picture import to_image
from cnnsim.support.values import Array

_CODECS = {".mp4": "libx264", ".mkv": "libx264", ".mov": "libx264", ".avi": "mpeg4"}
VIDEO_ENDINGS = (*_CODECS, ".webm", ".m4v", ".mpg", ".mpeg", ".ogv", ".wmv", ".flv", ".ts", ".y4m")
"""Endings of videos that PyAV reads; those of `_CODECS` are written as well."""
FILM_ENDINGS = (".gif", *_CODECS)
"""Endings of films that can be written."""
_WIDE = 256
"""Pixels to which a small picture is enlarged."""
STRIP = 16
"""Pixels of the strip with a caption."""
BETWEEN = 3
"""Pixels between layers."""
_PAUSE = 1000
"""Milliseconds for which a GIF shows its last picture before it repeats."""


class AddPicture(Protocol):
    """Adds a picture to a film."""

    def __call__(self, values: Array, caption: str = "") -> None:
        """Add CNN values (rows, cols), or of layers (layers, rows, cols).

        A ``caption`` is in a white strip below the cells, in all pictures of a film or in none.
        """


def is_film(path: str | Path) -> bool:
    """Return whether a path has the ending of a film that can be written."""
    return Path(path).suffix.lower() in FILM_ENDINGS


@contextmanager
def filming(path: str | Path, rate: float) -> Iterator[AddPicture]:
    """Yield a function that adds a picture (rows, cols) of CNN values to a film of ``rate`` pictures a second.

    Small pictures are enlarged; layers are side by side and numbered.

    Raises:
        InputError: an ending of no film, a video without PyAV, or the file cannot be written.
    """
    if not is_film(path):
        raise InputError(f"cannot write {path}: a film is one of {', '.join(FILM_ENDINGS)}")
    if Path(path).suffix.lower() != ".gif":
        video_library(path)  # so that the error has the user's path
    with writing(path) as temporary:
        yield from (_gif if temporary.suffix.lower() == ".gif" else _video)(temporary, rate)


def write_film(
    frames: Sequence[Array], path: str | Path, seconds: float = 3.0, times: Sequence[float] | None = None
) -> None:
    """Write CNN values over time as a film that runs for about ``seconds``.

    The ``times`` [time constants] of the frames are written below their cells.

    Raises:
        InputError: as `filming`.
    """
    with filming(path, len(frames) / seconds) as add:
        words = [""] * len(frames) if times is None else [f"t = {t:.3g}" for t in times]
        for frame, text in zip(frames, words, strict=True):
            add(frame, text.ljust(max(map(len, words))))  # all pictures of a film have one size


def video_library(path: str | Path) -> Any:
    """Return PyAV.

    Raises:
        InputError: it is not installed.
    """
    try:
        import av  # heavy, and of an extra
    except ImportError as error:
        raise InputError(f"{path}: a video needs PyAV: {install_line('video')}") from error
    return av


def _gif(path: Path, rate: float) -> Iterator[AddPicture]:
    images: list[Any] = []

    def add(values: Array, caption: str = "") -> None:
        images.append(_drawn(values, caption))

    yield add
    if not images:
        raise InputError(f"cannot write {path.name}: a film without a picture")
    lasting = [max(20, round(1000 / rate))] * (len(images) - 1) + [_PAUSE]
    images[0].save(path, format="GIF", save_all=True, append_images=images[1:], duration=lasting, loop=0)


def _video(path: Path, rate: float) -> Iterator[AddPicture]:
    av = video_library(path)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(_CODECS[path.suffix.lower()], rate=Fraction(rate).limit_denominator(1000))
        stream.pix_fmt = "yuv420p"

        def add(values: Array, caption: str = "") -> None:
            grey = np.asarray(_drawn(values, caption))
            grey = np.pad(grey, [(0, size % 2) for size in grey.shape], mode="edge")  # the codec takes even sizes only
            if not stream.codec_context.is_open:
                stream.height, stream.width = grey.shape
            for packet in stream.encode(av.VideoFrame.from_ndarray(grey, format="gray")):
                container.mux(packet)

        yield add
        for packet in stream.encode():
            container.mux(packet)


def _drawn(values: Array, caption: str) -> Image.Image:
    """Return a picture, enlarged if it is small, with a caption below; layers are side by side and numbered."""
    scale = max(1, _WIDE // max(values.shape))
    if values.ndim == 2:
        return _lettered(to_image(values, scale), caption)
    layers = [_lettered(to_image(plane, scale), f"layer {number}") for number, plane in enumerate(values)]
    width, height = layers[0].size
    whole = Image.new("L", (len(layers) * (width + BETWEEN) - BETWEEN, height), 255)
    draw = ImageDraw.Draw(whole)
    for number, layer in enumerate(layers):
        left = number * (width + BETWEEN)
        whole.paste(layer, (left, 0))
        if number:  # a dark line between light ones is visible next to any grey
            draw.line((left - BETWEEN // 2 - 1, 0, left - BETWEEN // 2 - 1, height), fill=0)
    return _lettered(whole, caption)


def _lettered(image: Image.Image, text: str) -> Image.Image:
    """Return a picture with an optional line of text in a white strip below it."""
    if not text:
        return image
    width = max(image.width, 8 * len(text))
    whole = Image.new("L", (width, image.height + STRIP), 255)
    whole.paste(image, (0, 0))
    draw = ImageDraw.Draw(whole)
    draw.line((0, image.height, width, image.height), fill=128)
    draw.text((3, image.height + 2), text, fill=0, font=ImageFont.load_default(11))
    return whole
