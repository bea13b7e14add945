"""The innermost loops of `cnnsim.backends.cpu.tiles.rows` as functions to call by address: the one a template needs."""

from functools import cache
from typing import Any

import numba
import numpy as np
from numba import carray, types

from cnnsim.backends.cpu.jit.address import call, compiled_at, pointer, pointer_type
from cnnsim.backends.cpu.jit.columns import tap_type
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.rows import any_taps, cross, isotropic, nine_taps
from cnnsim.support import Array


def _nine_taps(
    numbers: Any, cells: int, at_x: int, at_w: int, at_y: int, at_out: int, n: int, at_square: int, taps: Any,
    tap_count: int, r: int, at_row: int, h: float, blocks: int,
) -> None:  # fmt: skip
    scratch = carray(numbers, (cells,))
    nine_taps(scratch, at_x, scratch, at_w, scratch, at_y, scratch, at_out, n, scratch, at_square, h, blocks)


def _cross(
    numbers: Any, cells: int, at_x: int, at_w: int, at_y: int, at_out: int, n: int, at_square: int, taps: Any,
    tap_count: int, r: int, at_row: int, h: float, blocks: int,
) -> None:  # fmt: skip
    scratch = carray(numbers, (cells,))
    cross(scratch, at_x, scratch, at_w, scratch, at_y, scratch, at_out, n, scratch, at_square, h, blocks)


def _isotropic(
    numbers: Any, cells: int, at_x: int, at_w: int, at_y: int, at_out: int, n: int, at_square: int, taps: Any,
    tap_count: int, r: int, at_row: int, h: float, blocks: int,
) -> None:  # fmt: skip
    scratch = carray(numbers, (cells,))
    isotropic(scratch, at_x, scratch, at_w, scratch, at_y, scratch, at_out, n, scratch, at_square, h, blocks)


def _any_taps(
    numbers: Any, cells: int, at_x: int, at_w: int, at_y: int, at_out: int, n: int, at_square: int, taps: Any,
    tap_count: int, r: int, at_row: int, h: float, blocks: int,
) -> None:  # fmt: skip
    scratch = carray(numbers, (cells,))
    any_taps(scratch, at_x, at_w, at_y, at_out, n, carray(taps, (tap_count,)), r, at_row, h, blocks)


NINE, CROSS, ISOTROPIC, ANY = _nine_taps, _cross, _isotropic, _any_taps


@cache
def loop(kind: Any, dtype: np.dtype[Any]) -> Any:
    """Return one of the four, compiled for a dtype."""
    integer, cells, taps = types.int64, pointer_type(dtype), pointer_type(tap_type(dtype))
    return compiled_at(kind, types.void(cells, *7 * [integer], taps, *3 * [integer], numba.from_dtype(dtype), integer))


@helper
def step_block(
    loop: int, taps: Array, r: int, scratch: Array, at_row: int, at_square: int, at_x: int, at_w: int, at_y: int,
    at_out: int, n: int, h: float, blocks: int,
) -> None:  # fmt: skip
    """Step ``blocks`` blocks by the loop at an address; not given the feedback, whose references would be counted."""
    call(loop, (pointer(scratch), scratch.size, at_x, at_w, at_y, at_out, n, at_square, pointer(taps), taps.size, r,
                at_row, h, blocks))  # fmt: skip
