"""Planes as palette indices of one byte a cell: 16 is -1 (white), 128 is 0, 240 is +1 (black), others lie beyond."""

import numpy as np

from cnnsim.support import Array, InputError

WHITE, GREY, BLACK = 16, 128, 240
_PER_UNIT = 112.0
_BEYOND = 5.0
"""Indices per unit beyond -1 and +1: 15 of them reach to 4, larger values have the last one."""


def indices(x: Array) -> "np.ndarray[tuple[int, ...], np.dtype[np.uint8]]":
    """Return the palette indices of CNN values; any value beyond [-1, 1] has an index of its own."""
    inside = np.clip(x, -1, 1)
    beyond = x - inside
    inside *= _PER_UNIT
    inside += 128.5
    if beyond.any():
        beyond *= _BEYOND
        inside += np.clip(np.trunc(beyond) + np.sign(beyond), -16, 15)
    return inside.astype(np.uint8)


def values(data: bytes, shape: tuple[int, ...]) -> Array:
    """Return the CNN values from -1 to 1 of palette indices.

    Raises:
        InputError: another number of bytes than cells.
    """
    if len(data) != np.prod(shape):
        raise InputError(f"{len(data)} bytes for {' x '.join(map(str, shape))} cells; one a cell wanted")
    levels = np.frombuffer(data, np.uint8).reshape(shape)
    return ((levels.astype(np.float64) - GREY) / _PER_UNIT).clip(-1, 1)
