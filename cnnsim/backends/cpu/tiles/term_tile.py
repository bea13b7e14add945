"""Steps of a tile of a network of terms, or only its drives, while its rows are in the cache.

Rows stream through levels one by one, a level for each stage of each step. Level s has the channels of stage s; a row
comes to level s + 1 when the rows below it that terms look at have come to level s. The tile is loaded with r more
cells on all sides for each level: each level spoils r of them, and the rest is exact. At the edge of the grid the
virtual cells are set at every level. All rows of a small torus go through a level before the next, because its
surroundings would be larger than the grid.
"""

from typing import Any, NamedTuple

import numpy as np

from cnnsim.backends.codes import NOTHING, FunctionCode, TaskCode
from cnnsim.backends.cpu.compiled import helper, uncounted
from cnnsim.backends.cpu.tiles.channels import PERIODIC, fill_channels, find_lines
from cnnsim.backends.cpu.tiles.functions import copy_row, fill, function_row
from cnnsim.backends.cpu.tiles.rows import PAD
from cnnsim.backends.cpu.tiles.stage_rows import (
    LiveRows,
    begin_step,
    check_row,
    differs,
    discrete_row,
    euler_row,
    keep_masked,
    largest_change,
    next_stage,
    stop_row,
)
from cnnsim.backends.cpu.tiles.term_sums import WorkRows, add_terms, load_row
from cnnsim.support import Array

SIGN = int(FunctionCode.SIGN)
DRIVE, DISCRETE, STEP, CHECK = map(int, TaskCode)


class TermRule(NamedTuple):
    """Constants of the steps of a network.

    ``function`` and ``step`` are addresses of `functions` and `step_tile`. ``gains`` of the layers; ``limited``: states
    stay within +-1. ``table`` of the scheme: a row by row, then b; ``ahead``: steps by which each stage looks ahead;
    ``keeps``: a stage needs the rate of another than the last one. ``kind``, ``places`` and ``values`` of the output
    characteristic. ``channels``, ``terms`` and ``taps`` are records; ``weights`` (number, rows, cols) differ from cell
    to cell; ``numbers`` of all tables. ``r``, ``code``, ``of_input`` and ``of_state``: radius, `BoundaryCode` and fixed
    virtual cells. ``low``: the rows of a small torus, else 0.
    """

    function: int
    step: int
    gains: Array
    limited: bool
    table: Array
    ahead: Array
    keeps: bool
    kind: int
    places: Array
    values: Array
    channels: Array
    terms: Array
    taps: Array
    weights: Array
    numbers: Array
    r: int
    code: int
    of_input: Any
    of_state: Any
    low: int


class TermPlanes(NamedTuple):
    """Planes (n, layers, rows, cols) of a task.

    ``start`` is the state of step 0; ``states`` (k, n, ...) those of later steps in turn, step m at m modulo k;
    ``inputs`` (k, n, ...) of channels; ``w``; and the ``mask`` as truth values, without cells none.
    """

    start: Array
    states: Array
    inputs: Array
    w: Array
    mask: Array


class Job(NamedTuple):
    """A task for the cells [r0, r1) x [c0, c1) of grid g from the state ``number``; STEP takes ``steps`` at once."""

    task: int
    number: int
    steps: int
    g: int
    r0: int
    r1: int
    c0: int
    c1: int


@helper
def inset(r: int) -> int:
    """Return how many cells before its first cell a row of a channel begins."""
    return (r + PAD - 1) // PAD * PAD


@helper
def tile_sizes(rule: TermRule, width: int, depth: int) -> tuple[int, int, int, int]:
    """Return the live rows, the rates kept for each, the rows of a ring and the cells of a row of a tile that takes
    ``depth`` steps at once.
    """
    _, _, _, _, _, ahead, keeps, _, _, _, _, _, _, _, _, r, _, _, _, low = rule
    levels = depth * ahead.size
    # an odd number of vectors, so that rows that are used together do not fight for cache sets
    stride = inset(r) + PAD * (((width + r + PAD - 1) // PAD) | 1)
    live = 0 if levels == 1 else low if low else levels * r + 1
    return live, ahead.size * keeps, low if low else 2 * r + 1, stride


def step_tile(
    job: Job, planes: TermPlanes, rule: TermRule, live: LiveRows, rings: Array, work: WorkRows, found: Array
) -> None:
    """Do a job in all layers of a grid.

    The ``live`` rows, the ``rings`` of rows of channels (levels, channels, cells) and ``work`` are scratch memory.
    ``found`` gets the largest rate or change of each layer; then whether a row differs from that of two steps ago, and
    whether a cell is not saturated.
    """
    task, number, steps, g, r0, r1, c0, c1 = job
    start, states, inputs = uncounted(planes[0]), uncounted(planes[1]), uncounted(planes[2])
    w, mask, rings = uncounted(planes[3]), uncounted(planes[4]), uncounted(rings)
    live = LiveRows(
        uncounted(live.state), uncounted(live.stage), uncounted(live.total), uncounted(live.mask), uncounted(live.rates)
    )
    function, _, gains, limited, table, ahead, keeps, kind, places, values = rule[:10]
    channels, terms, taps, weights, numbers, r, code, of_input, of_state, low = rule[10:]
    field = uncounted(terms), uncounted(taps), uncounted(weights), uncounted(numbers)
    scheme, gains, ahead = (uncounted(table), ahead.size, keeps), uncounted(gains), uncounted(ahead)
    channels, places, values = uncounted(channels), uncounted(places), uncounted(values)
    of_channels = function, channels, (kind, places, values), (r, code, of_input, of_state)
    (_, layers, rows, cols), kept, masked = start.shape, states.shape[0], mask.size > 0
    levels, count = steps * ahead.size if task == STEP else 1, ahead.size
    lag, ring = (low, low) if low else (r, 2 * r + 1)
    wraps, reach = code == PERIODIC and not low, 0 if low else levels * r
    lo, hi, top, bottom = c0 - reach, c1 + reach, r0 - reach, r1 + reach
    if not wraps:
        lo, hi, top, bottom = max(lo, 0), min(hi, cols), max(top, 0), min(bottom, rows)
    n, inner, wanted, stride, first = hi - lo, c0 - lo, c1 - c0, rings.shape[2] // (ring + 1), inset(r)
    rows_of = WorkRows(
        uncounted(work.drive)[:n], uncounted(work.difference)[:n], uncounted(work.product)[:n],
        uncounted(work.weights)[:n], uncounted(work.zeros)[:n], uncounted(work.mask)[:n], uncounted(work.spare)[:n],
    )  # fmt: skip
    drive, to, spare = rows_of.drive, rows_of.drive[inner : inner + wanted], rows_of.spare[:wanted]
    fill(rows_of.zeros, 0)
    for level in range(levels):
        for m in range(channels.size):
            at = ring * stride + first
            fill(rings[level, m][at - r : at + n + r], of_input if channels[m]["plane"] >= 0 else of_state)
    now = start[g] if number == 0 else states[number % kept, g]
    last = start[g] if number <= 1 else states[(number - 1) % kept, g]
    after = states[(number + 1) % kept, g]
    lines, sources = np.empty(2 * r + 1, np.int64), (start, states, inputs, g, rows_of.spare)
    for base in range(top, r1 + levels * lag):
        for level in range(levels + 1):
            i, margin = base - level * lag, (levels - level) * r
            if i < max(r0 - margin, top) or i >= min(r1 + margin, bottom):
                continue
            slot, place = (i - top) % ring, (i - top) % max(1, live.state.shape[1])
            if level > 0:
                find_lines(lines, i, slot, (ring, stride, first), (rows, code, low > 0))
            for layer in range(layers if level > 0 or levels > 1 else 0):
                if level == 0:
                    load_row(rows_of.spare, now[layer], i, lo)
                    begin_step(live, (layer, place), rows_of.spare, gains[layer])
                    if masked:
                        load_row(live.mask[layer, place][:n], mask[g, layer], i, lo)
                    continue
                load_row(drive, w[g, layer], i, lo)
                add_terms(function, rows_of, rings[level - 1], lines, layer, field, (i, lo))
                if levels > 1:
                    at_row, stage = (layer, place), (level - 1) % count
                    next_stage(live, at_row, rows_of, scheme, stage, gains[layer], (limited, masked))
                    if level == levels:
                        copy_row(after[layer, i][c0:c1], rows_of.spare[inner : inner + wanted])
                    elif stage + 1 == count:
                        begin_step(live, at_row, rows_of.spare, gains[layer])
                    continue
                held, x = rows_of.mask[:wanted], now[layer, i][c0:c1]
                if masked:
                    load_row(held, mask[g, layer], i, c0)
                if task == DRIVE:
                    copy_row(w[g, layer, i][c0:c1], to)
                elif task == STEP:
                    euler_row(spare, x, gains[layer] if gains[layer] != 0 else scheme[0][1], to)
                    stop_row(spare, x, held, limited, masked)
                    copy_row(after[layer, i][c0:c1], spare)
                elif task == CHECK:
                    rate, unsaturated = check_row(to, x, held, limited, masked)
                    found[layer] = max(found[layer], rate)
                    found[layers + 1] = max(found[layers + 1], found.dtype.type(unsaturated))
                else:
                    function_row(function, spare, to, kind, places.size, places, values)
                    discrete_row(spare, to, x, kind == SIGN)
                    if masked:
                        keep_masked(spare, held, x)
                    found[layer] = max(found[layer], largest_change(spare, x))
                    if differs(spare, last[layer, i][c0:c1]):
                        found[layers] = 1
                    copy_row(after[layer, i][c0:c1], spare)
            if level < levels:
                fill_channels(
                    of_channels, sources, rings[level], slot * stride + first, live.stage,
                    place if levels > 1 else NOTHING, (number, ahead[level % count]), (i, lo, n, not wraps),
                )  # fmt: skip
