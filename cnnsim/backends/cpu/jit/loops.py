"""The innermost loops of `cnnsim.backends.cpu.euler.rows` as functions to call by address: the one a template needs."""

from functools import cache
from typing import Any

import numba
import numpy as np
from numba import carray, types

from cnnsim.backends.cpu.euler.rows import any_taps, cross, isotropic, nine_taps
from cnnsim.backends.cpu.jit.address import call, compiled_at, numbers_of, place
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.support import Array


def _nine_taps(
    numbers: Any, cells: int, at_x: int, at_w: int, at_y: int, at_out: int, n: int, at_square: int, k: Any, l: Any,
    weight: Any, taps: int, r: int, at_row: int, h: float, blocks: int,
) -> None:  # fmt: skip
    room = carray(numbers, (cells,))
    nine_taps(room, at_x, room, at_w, room, at_y, room, at_out, n, room, at_square, h, blocks)


def _cross(
    numbers: Any, cells: int, at_x: int, at_w: int, at_y: int, at_out: int, n: int, at_square: int, k: Any, l: Any,
    weight: Any, taps: int, r: int, at_row: int, h: float, blocks: int,
) -> None:  # fmt: skip
    room = carray(numbers, (cells,))
    cross(room, at_x, room, at_w, room, at_y, room, at_out, n, room, at_square, h, blocks)


def _isotropic(
    numbers: Any, cells: int, at_x: int, at_w: int, at_y: int, at_out: int, n: int, at_square: int, k: Any, l: Any,
    weight: Any, taps: int, r: int, at_row: int, h: float, blocks: int,
) -> None:  # fmt: skip
    room = carray(numbers, (cells,))
    isotropic(room, at_x, room, at_w, room, at_y, room, at_out, n, room, at_square, h, blocks)


def _any_taps(
    numbers: Any, cells: int, at_x: int, at_w: int, at_y: int, at_out: int, n: int, at_square: int, k: Any, l: Any,
    weight: Any, taps: int, r: int, at_row: int, h: float, blocks: int,
) -> None:  # fmt: skip
    any_taps(carray(numbers, (cells,)), at_x, at_w, at_y, at_out, n, carray(k, (taps,)), carray(l, (taps,)),
             carray(weight, (taps,)), r, at_row, h, blocks)  # fmt: skip


NINE, CROSS, ISOTROPIC, ANY = _nine_taps, _cross, _isotropic, _any_taps


@cache
def loop(kind: Any, dtype: np.dtype[Any]) -> Any:
    """Return one of the four, compiled for a dtype."""
    integer, cells, offsets = types.int64, numbers_of(dtype), numbers_of(np.dtype(np.int64))
    return compiled_at(
        kind,
        types.void(cells, *7 * [integer], offsets, offsets, cells, *3 * [integer], numba.from_dtype(dtype), integer),
    )


@helper
def step_block(
    loop: int, k: Array, l: Array, weight: Array, r: int, room: Array, at_row: int, at_square: int, at_x: int,
    at_w: int, at_y: int, at_out: int, n: int, h: float, blocks: int,
) -> None:  # fmt: skip
    """Step ``blocks`` blocks by the loop at an address. (A rule is not handed on whole: references are counted.)"""
    call(loop, (place(room), room.size, at_x, at_w, at_y, at_out, n, at_square, place(k), place(l), place(weight),
         weight.size, r, at_row, h, blocks))  # fmt: skip
