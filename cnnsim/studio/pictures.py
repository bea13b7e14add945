"""Pictures to begin with: closed curves, shapes, letters and noise, each from a seed, on a grid of any size."""

from collections.abc import Callable

import numpy as np
from PIL import Image, ImageDraw

from cnnsim.support import Array, Floats
from cnnsim.support.errors import not_known
from cnnsim.support.values import from_gray

SIDES = (4, 1024)
"""The shortest and the longest side of a grid [cells]."""
Draw = Callable[[ImageDraw.ImageDraw, int, int, np.random.Generator], None]


def make_picture(name: str, shape: tuple[int, int], seed: int = 0) -> Floats:
    """Return a picture (rows, cols) of CNN values; the same seed gives the same picture.

    Raises:
        InputError: no such picture.
    """
    if name not in NAMES:
        raise not_known("picture", name, NAMES)
    rng = np.random.default_rng(seed)
    if name in _PLANES:
        return _PLANES[name](shape, rng)
    image = Image.new("L", shape[::-1], 255)
    _DRAWN[name](ImageDraw.Draw(image), *shape, rng)
    return from_gray(np.asarray(image))


def moving(picture: Array, frames: int) -> Array:
    """Return a picture as a sequence (frames, rows, cols) that moves to the right by a cell a frame."""
    return np.array([np.roll(picture, k, axis=-1) for k in range(frames)])


def with_noise(picture: Array, sigma: float, seed: int) -> Floats:
    """Return a picture with Gaussian noise of a standard deviation, clipped to [-1, 1]."""
    return np.clip(picture + sigma * np.random.default_rng(seed).standard_normal(picture.shape), -1, 1)


def _curves(draw: ImageDraw.ImageDraw, rows: int, cols: int, rng: np.random.Generator) -> None:
    """Draw closed curves and one open one."""
    width = max(1, min(rows, cols) // 40)
    for _ in range(5):
        cx, cy, size = (
            rng.uniform(0.2, 0.8) * cols,
            rng.uniform(0.2, 0.8) * rows,
            rng.uniform(0.07, 0.2) * min(rows, cols),
        )
        angles = np.linspace(0, 2 * np.pi, 60)
        r = size * (1 + 0.3 * np.sin(rng.integers(2, 5) * angles + rng.uniform(0, 6)))
        points = list(zip(cx + r * np.cos(angles), cy + r * np.sin(angles), strict=True))
        draw.line(points, fill=0, width=width)
    draw.arc((cols * 0.05, rows * 0.05, cols * 0.3, rows * 0.3), 20, 300, fill=0, width=width)


def _shapes(draw: ImageDraw.ImageDraw, rows: int, cols: int, rng: np.random.Generator) -> None:
    for number in range(6):
        h, w = rng.uniform(0.08, 0.25, 2) * (rows, cols)
        top, left = rng.uniform(0.03, 0.7, 2) * (rows, cols)
        (draw.ellipse if number % 2 else draw.rectangle)((left, top, left + w, top + h), fill=0)


def _dot(draw: ImageDraw.ImageDraw, rows: int, cols: int, rng: np.random.Generator) -> None:
    draw.rectangle((cols // 2 - 1, rows // 2 - 1, cols // 2 + 1, rows // 2 + 1), fill=0)


def _lines(draw: ImageDraw.ImageDraw, rows: int, cols: int, rng: np.random.Generator) -> None:
    for _ in range(8):
        (x, y), (dx, dy) = rng.integers(0, (cols, rows)), rng.choice([(1, 0), (0, 1), (1, 1), (1, -1)])
        length = int(rng.uniform(0.2, 0.6) * min(rows, cols))
        draw.line((x, y, x + dx * length, y + dy * length), fill=0, width=max(1, min(rows, cols) // 50))


def _binary(shape: tuple[int, int], rng: np.random.Generator) -> Floats:
    return np.where(rng.random(shape) < 0.5, -1.0, 1.0)


def _waves(shape: tuple[int, int], rng: np.random.Generator) -> Floats:
    rows, cols = np.mgrid[0 : shape[0], 0 : shape[1]] / max(shape)
    (a, b), (c, d) = rng.uniform(4, 14, (2, 2))
    return 0.5 * np.sin(a * rows + b * cols) + 0.5 * np.sin(c * cols - d * rows)


_DRAWN: dict[str, Draw] = {"curves": _curves, "shapes": _shapes, "lines": _lines, "dot": _dot}
_PLANES: dict[str, Callable[[tuple[int, int], np.random.Generator], Floats]] = {
    "waves": _waves,
    "ramp": lambda shape, _: np.broadcast_to(np.linspace(1, -1, shape[1]), shape).copy(),
    "noise": lambda shape, rng: rng.uniform(-1, 1, shape),
    "black and white noise": _binary,
    "white": lambda shape, _: np.full(shape, -1.0),
}
NAMES = (*_DRAWN, *_PLANES)
"""The pictures by name."""
