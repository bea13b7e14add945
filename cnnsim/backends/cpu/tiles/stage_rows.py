"""Rows of a stage of a network of terms: the next stage, the state after a step, discrete outputs and checks.

k_i = drive of x_i - x_i,    x_i = x + gain (sum of a_ij k_j over j < i),    x <- x + gain (sum of b_i k_i)
"""

from typing import Any, NamedTuple

from cnnsim.backends.cpu.compiled import helper
from cnnsim.backends.cpu.tiles.check import saturated
from cnnsim.backends.cpu.tiles.functions import clip_row, copy_row, fill
from cnnsim.backends.cpu.tiles.term_sums import WorkRows, add_weighted, subtract
from cnnsim.support import Array


class LiveRows(NamedTuple):
    """Rows (layers, rows, cells) of a scheme of some stages that are between its levels.

    The ``state``, the ``stage``, the ``total`` of the weighted rates so far, the ``mask``; and, where later stages need
    them, the ``rates`` of all stages, as many rows one after the other for each live row.
    """

    state: Array
    stage: Array
    total: Array
    mask: Array
    rates: Array


@helper
def keep_masked(out: Array, mask: Array, x: Array) -> None:
    """Write x where cells are masked."""
    for j in range(out.size):
        out[j] = x[j] if mask[j] else out[j]


@helper
def euler_row(out: Array, x: Array, gain: float, drive: Array) -> None:
    """Write the state after an Euler step."""
    for j in range(out.size):
        out[j] = x[j] + gain * (drive[j] - x[j])


@helper
def _stage_row(drive: Array, stage: Array, total: Array, x: Array, weights: tuple[float, float], gain: float) -> None:
    """Add the rate, drive - stage, to the total, and replace the drive by the next stage."""
    b, a = weights
    zero = x.dtype.type(0)
    for j in range(drive.size):
        k = drive[j] - stage[j]
        total[j] += b * k
        drive[j] = x[j] + gain * (zero + a * k)


@helper
def _last_row(out: Array, drive: Array, stage: Array, total: Array, x: Array, weights: tuple[float, float]) -> None:
    """Write the state after the step, from the drive of the last stage; a gain of 0: the total begins with x."""
    b, gain = weights
    if gain == 0:
        for j in range(out.size):
            out[j] = total[j] + b * (drive[j] - stage[j])
    else:
        for j in range(out.size):
            out[j] = x[j] + gain * (total[j] + b * (drive[j] - stage[j]))


@helper
def _sum_row(out: Array, x: Array, gain: float, total: Array) -> None:
    for j in range(out.size):
        out[j] = x[j] + gain * total[j]


@helper
def stop_row(row: Array, x: Array, mask: Array, limited: bool, masked: bool) -> None:
    """Keep states within +-1 where they are limited, and as they were where they are masked."""
    if limited:
        clip_row(row, row, row.dtype.type(1))
    if masked:
        keep_masked(row, mask, x)


@helper
def begin_step(live: LiveRows, at: tuple[int, int], x: Array, gain: float) -> None:
    """Begin a step from a row of the state; ``at`` are the layer and the live row."""
    (layer, place), n = at, x.size
    copy_row(live.state[layer, place][:n], x)
    copy_row(live.stage[layer, place][:n], x)
    if gain == 0:
        copy_row(live.total[layer, place][:n], x)
    else:
        fill(live.total[layer, place][:n], 0)


@helper
def next_stage(
    live: LiveRows, at: tuple[int, int], work: WorkRows, scheme: Any, stage: int, gain: float, how: tuple[bool, bool]
) -> None:  # fmt: skip
    """Go from the drives of a stage, in ``work``, to the next stage; after the last one ``spare`` is the new state.

    ``at``: the layer and the live row. ``how``: whether states are limited, and masked. Of a linear template
    ``gain`` is 0: the table has the length of a step as a factor, and the total begins with the state.
    """
    (layer, place), (table, count, keeps), n = at, scheme, work.drive.size
    ahead = gain if gain != 0 else work.drive.dtype.type(1)
    x, of_stage, total = live.state[layer, place][:n], live.stage[layer, place][:n], live.total[layer, place][:n]
    mask, drive, spare = live.mask[layer, place][:n], work.drive, work.spare
    b, row = table[count * count + stage], (stage + 1) * count
    if stage + 1 == count:
        _last_row(spare, drive, of_stage, total, x, (b, gain))
        stop_row(spare, x, mask, how[0], how[1])
        return
    if keeps:
        rates = live.rates[layer, place * count : (place + 1) * count]
        subtract(drive, drive, of_stage)
        add_weighted(total, b, drive)
        copy_row(rates[stage][:n], drive)
        if gain == 0:
            copy_row(spare, x)
        else:
            fill(spare, 0)
        for earlier in range(stage + 1):
            add_weighted(spare, table[row + earlier], rates[earlier][:n])
        if gain == 0:
            copy_row(drive, spare)
        else:
            _sum_row(drive, x, gain, spare)
    else:
        _stage_row(drive, of_stage, total, x, (b, table[row + stage]), ahead)
    stop_row(drive, x, mask, how[0], how[1])
    copy_row(of_stage, drive)


@helper
def check_row(drive: Array, x: Array, mask: Array, limited: bool, masked: bool) -> Any:
    """Return the largest |drive - x| of the free cells, and whether one of them is not saturated."""
    largest, one, unsaturated = x.dtype.type(0), x.dtype.type(1), False
    for j in range(x.size):
        change = drive[j] - x[j]
        against = limited and ((x[j] >= 1 and change > 0) or (x[j] <= -1 and change < 0))
        if not (masked and mask[j]):
            unsaturated |= not saturated(x[j], drive[j], one)
            if not against:
                largest = max(largest, abs(change))
    return largest, unsaturated


@helper
def discrete_row(new: Array, drive: Array, y: Array, sign: bool) -> None:
    """Keep the old outputs where the drive of a sign is 0."""
    if sign:
        for j in range(new.size):
            new[j] = y[j] if drive[j] == 0 else new[j]


@helper
def largest_change(v: Array, w: Array) -> Any:
    """Return the largest |v - w|."""
    change = v.dtype.type(0)
    for j in range(v.size):
        change = max(change, abs(v[j] - w[j]))
    return change


@helper
def differs(v: Array, w: Array) -> bool:
    """Return whether two rows differ."""
    count = 0
    for j in range(v.size):
        count += v[j] != w[j]
    return count > 0
