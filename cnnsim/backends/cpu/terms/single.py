"""Rows of which one drive is all that is asked: Euler steps, steps of discrete time, and how much would change.

Rows are given as a flat array and where they begin; ``held`` has 1 for cells that a mask holds.
"""

from typing import Any

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.row_sums import keep_held, outputs
from cnnsim.support import Array


@helper
def euler_row(
    out: Array, at_out: int, drive: Array, at_drive: int, x: Array, at_x: int, held: Array, at_held: int, n: int,
    gain: float, limited: bool, masked: bool,
) -> None:  # fmt: skip
    """Write x + gain (drive - x), within +-1 where states are ``limited``."""
    after, to, before = out[at_out : at_out + n], drive[at_drive : at_drive + n], x[at_x : at_x + n]
    for j in range(n):
        after[j] = before[j] + gain * (to[j] - before[j])
    if limited:
        outputs(out, at_out, out, at_out, n)
    if masked:
        keep_held(out, at_out, held, at_held, x, at_x, n)


@helper
def largest_rate(
    drive: Array, at_drive: int, x: Array, at_x: int, held: Array, at_held: int, n: int, limited: bool, masked: bool
) -> Any:
    """Return the largest |drive - x| of cells that are free to go there."""
    drive, x, held = drive[at_drive : at_drive + n], x[at_x : at_x + n], held[at_held : at_held + n]
    rate = x.dtype.type(0)
    for j in range(n):
        change = drive[j] - x[j]
        against = limited and ((x[j] >= 1 and change > 0) or (x[j] <= -1 and change < 0))
        if not against and not (masked and held[j] > 0):
            rate = max(rate, abs(change))
    return rate


@helper
def discrete_row(
    new: Array, at_new: int, drive: Array, at_drive: int, y: Array, at_y: int, held: Array, at_held: int, n: int,
    sign: bool, masked: bool,
) -> Any:  # fmt: skip
    """Keep the old outputs of cells that are held, or whose ``sign`` is of 0; return the largest change."""
    after, to, before = new[at_new : at_new + n], drive[at_drive : at_drive + n], y[at_y : at_y + n]
    if sign:
        for j in range(n):
            after[j] = before[j] if to[j] == 0 else after[j]
    if masked:
        keep_held(new, at_new, held, at_held, y, at_y, n)
    change = y.dtype.type(0)
    for j in range(n):
        change = max(change, abs(after[j] - before[j]))
    return change


@helper
def differs(v: Array, at_v: int, w: Array, at_w: int, n: int) -> bool:
    """Return whether a row is another one than w."""
    v, w = v[at_v : at_v + n], w[at_w : at_w + n]
    count = 0
    for j in range(n):
        count += v[j] != w[j]
    return count > 0
