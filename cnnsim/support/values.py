"""CNN values from arrays: black is +1, white is -1, a grey level g of 0..255 is 1 - 2 g / 255; array types."""

from __future__ import annotations

import warnings
from numbers import Integral
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cnnsim.support.errors import InputError, shown
from cnnsim.support.notices import users_level

Array = NDArray[Any]
"""An array of any numbers."""

Floats = NDArray[np.float64]
"""An array of float64 numbers."""

Integers = NDArray[np.int64]
"""An array of whole numbers."""

Flags = NDArray[np.bool_]
"""An array of truth values."""


def is_number(value: Any) -> TypeGuard[float]:
    """Return whether a value is a real number of Python or NumPy, and no boolean."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def is_whole(value: Any) -> TypeGuard[int]:
    """Return whether a value is a whole number of Python or NumPy, and no boolean."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def is_stored(plane: Any) -> bool:
    """Return whether a plane is a Zarr array, without importing zarr."""
    return type(plane).__module__.split(".")[0] == "zarr"


def stored_plane(name: str, plane: Any) -> Any:
    """Return a stored plane.

    Raises:
        InputError: its numbers are neither floats nor booleans.
    """
    if np.dtype(plane.dtype).kind not in "bf":
        raise InputError(f"{name} is a stored plane of {plane.dtype}; CNN values as floats, or truth values, wanted")
    return plane


def from_gray(levels: ArrayLike, top: float = 255.0) -> Floats:
    """Return grey levels from 0 (black) to ``top`` (white) as CNN values, 1 - 2 g / top.

    Raises:
        InputError: levels outside that range, floats up to 1 with a ``top`` of 255, no array of numbers.
    """
    return 1.0 - _checked_levels("grey levels", levels, top) * (2.0 / top)


def to_planes(colours: ArrayLike, top: float = 255.0) -> Floats:
    """Return a colour picture (rows, cols, 3 or 4) as CNN values (3, rows, cols), transparency over white.

    Raises:
        InputError: another shape, or levels as in `from_gray`.
    """
    levels = _checked_levels("levels of colours", colours, top)
    if levels.ndim != 3 or levels.shape[-1] not in (3, 4):
        raise InputError(f"colours of shape {levels.shape}; (rows, cols, 3 or 4) wanted")
    cover = levels[..., 3:] / top if levels.shape[-1] == 4 else 1.0
    return np.moveaxis(1.0 - (top + (levels[..., :3] - top) * cover) * (2.0 / top), -1, 0)


def _checked_levels(name: str, levels: ArrayLike, top: float) -> Floats:
    try:
        given = np.asarray(levels)
    except ValueError as error:
        raise InputError(f"{name}: no rectangular array of numbers") from error
    if given.dtype.kind not in "iuf":
        cure = "; booleans are taken as they are: True is black" if given.dtype == bool else ""
        raise InputError(f"{name} of type {given.dtype}; numbers wanted{cure}")
    least, most = given.min(initial=0.0), given.max(initial=0.0)
    if not 0 <= least <= most <= top:
        raise InputError(f"{name} from {given.min():g} to {given.max():g}; 0 to {top:g} wanted, or another top")
    if given.dtype.kind == "f" and top == 255 and 0 < most <= 1:
        raise InputError(
            f"{name} up to {most:g} of {top:g}, nearly all black; a top, as of from_gray(values, 1), wanted"
        )
    return given.astype(np.float64)


def as_numbers(name: str, values: ArrayLike, *, levels: bool = False, logic: bool = False) -> Array:
    """Return a plane as an array of numbers: booleans become +1 and -1, floats and single numbers are unchanged.

    ``levels`` accepts any whole numbers except bytes above 1, which are grey levels; ``logic`` accepts 0 and 1.

    Raises:
        InputError: no array of numbers, or whole numbers that look like grey levels, truth values or colours.
    """
    if np.ma.is_masked(values):
        raise InputError(f"{name} is a masked array; a plain one wanted, as of values.filled(0), and a mask of its own")
    if isinstance(values, np.ndarray) and values.dtype.kind == "f":
        return values
    if isinstance(values, str | Path):
        raise InputError(f"{name} is {str(values)!r}; an array of numbers wanted: cnnsim.read_picture(path)")
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{name} is no rectangular array of numbers{_unequal(values)}") from error
    if array.dtype == object and not array.ndim:
        cure = ": the list of its planes" if hasattr(values, "planes") else ""
        raise InputError(f"{name} is {shown(values)}; an array of numbers wanted{cure}")
    if array.dtype == bool:
        return np.where(array, 1.0, -1.0)
    if array.dtype.kind == "f":
        return array
    if levels and array.dtype.kind in "iu" and (array.dtype != np.uint8 or array.max(initial=0) <= 1):
        return array
    if array.dtype.kind not in "iu":
        raise InputError(f"{name} holds {array.dtype} values; real numbers or booleans wanted")
    if not array.size:
        return array
    least, most = int(array.min()), int(array.max())
    if logic and 0 <= least <= most <= 1:
        return array
    if least == 0 and most == 1:
        raise InputError(
            f"{name} holds the whole numbers 0 and 1, and 0 is mid-grey; CNN values from -1 (white) to 1 (black), or "
            "booleans, wanted: values > 0"
        )
    if least == most == 0 and array.ndim and array.dtype.kind == "i":
        raise InputError(
            f"{name} holds the whole number 0 alone, shape {array.shape}: black as a grey level, white as a truth "
            "value, mid-grey as a CNN value; cnnsim.from_gray(values), values > 0, or floats, wanted"
        )
    if array.dtype.kind == "u" or max(most, -least) > 1:
        colours = array.ndim == 3 and array.shape[-1] in (3, 4)
        cure = "to_planes(values), a plane a colour" if colours else "from_gray(values)"
        cure += "; values > 0 where they are truth values" if (logic or most <= 1) and not colours else ""
        raise InputError(
            f"{name} holds whole numbers from {least} to {most}, shape {array.shape}; CNN values from -1 "
            f"(white) to 1 (black) wanted: cnnsim.{cure}"
        )
    return array


def shape_of(name: str, values: Any) -> tuple[int, ...]:
    """Return the shape of a plane, in memory or stored.

    Raises:
        InputError: rows of unequal length.
    """
    try:
        return np.shape(values)
    except ValueError as error:
        raise InputError(f"{name} is no rectangular array of numbers{_unequal(values)}") from error


def _unequal(values: Any) -> str:
    """Return the end of a message about two values of unequal shape; an empty text if all shapes are equal."""
    try:
        shapes = [np.shape(value) for value in values]
    except (ValueError, TypeError):
        return ""
    other = next((k for k, shape in enumerate(shapes) if shape != shapes[0]), 0)
    return f": entry 0 has shape {shapes[0]}, entry {other} {shapes[other]}; one shape wanted" if other else ""


LEAST_CELLS = 16
"""Cells of a picture from which on its range is judged."""
SAMPLED = 64
"""Rows, columns and grids that are looked at before all cells are."""
STRIP = 256
"""Rows of a stored plane that are read at a time."""


def distinct(array: Array) -> Array:
    """Return a view without the repeated cells of `numpy.broadcast_to`."""
    return array[tuple(slice(None) if stride else slice(0, 1) for stride in array.strides)]


def largest(array: Array) -> float:
    """Return the largest absolute value, or NaN, without a temporary plane."""
    values = distinct(array)
    return max(float(values.max()), -float(values.min())) if values.size else 0.0


def is_grey(state: Any) -> bool:
    """Return whether a state, in memory or stored, has cells that are not saturated."""
    values = distinct(state) if isinstance(state, np.ndarray) else state
    strips = (np.asarray(values[..., row : row + STRIP, :]) for row in range(0, values.shape[-2], STRIP))
    rows = (row for strip in strips if strip.dtype != bool for row in strip.reshape(-1, strip.shape[-1]))
    return any(bool((np.abs(row) < 1).any()) for row in rows)


def has_zeros_for_white(array: Array) -> bool:
    """Return whether an array has only the values 0, or 0 and 1: probably truth values as floats."""
    values = distinct(array)
    if not values.size or values.min() != 0 or values.max() not in (0, 1):
        return False
    return bool(((values == 0) | (values == 1)).all())


def _is_grey_level(array: Array) -> bool:
    """Return whether a picture looks like floats from 0 to 1: values in both halves and between, none below 0.

    CNN values of a dark picture of 8 bits are odd multiples of 1 / 255, which tells them apart.
    """
    if array.dtype.kind != "f" or array.size < LEAST_CELLS:
        return False
    sample = array[tuple(slice(None, None, 1 + n // SAMPLED) for n in array.shape)]
    if not 0 <= sample.min() < 0.5 < sample.max() <= 1 or not ((sample > 0) & (sample < 1)).any():
        return False
    from_a_file = bool((np.abs((sample * 255 + 1) % 2 - 1) > 1 - 1e-3).all())
    return not from_a_file and bool(array.min() >= 0 and array.max() <= 1)


def as_picture(name: str, values: ArrayLike, *, logic: bool = False) -> Array:
    """Return a picture as `as_numbers`; one outside of [-1, 1], or of grey levels from 0 to 1, gives a warning.

    Raises:
        InputError: as `as_numbers`; a shape (rows, cols, 3 or 4), which looks like colours.
    """
    array = as_numbers(name, values, logic=logic)
    if array.ndim == 3 and array.shape[-1] in (3, 4) and min(array.shape[:2]) > 4:
        raise InputError(
            f"{name} has shape {array.shape}, which reads as colours; (rows, cols) or (n, rows, cols) wanted: "
            f"cnnsim.to_planes(values, top) makes a plane a colour; grids {array.shape[-1]} wide are run one by one"
        )
    if _is_grey_level(array):
        said = (
            f"{name} lies from 0 to 1, as grey levels of scikit-image and matplotlib do; CNN values lie from -1 (white)"
        )
        warnings.warn(f"{said} to 1 (black): cnnsim.from_gray(values, 1) converts", stacklevel=users_level())
    most = largest(array)
    if 1 < most < np.inf:
        said = f"{name} reaches {most:.9g}; CNN values lie from -1 (white) to 1 (black)"
        warnings.warn(said, stacklevel=users_level())
    return array
