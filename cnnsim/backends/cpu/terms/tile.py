"""One step of a tile of a network of terms while its rows are in the cache: all stages, or what they drive.

Rows stream through levels one by one; level s has the channels of stage s, and a row comes to level s + 1 when the rows
below it that terms look at have come to level s. So of a stage no more is kept than these rows. The tile is loaded with
r cells more all round for each level: what comes in from outside spoils r of them a level, and what is left at the end
is exact. At the rim of the grid the virtual cells are set again at every level. Of a low torus (see `TermTiles`) all
rows go through a level before the next: the rows around it would be more than its own.
"""

from typing import Any

import numpy as np

from cnnsim.backends.codes import NOTHING, FunctionCode, TaskCode
from cnnsim.backends.cpu.jit.address import bare, uncounted
from cnnsim.backends.cpu.terms.channels import PERIODIC, fill_channels, find_lines
from cnnsim.backends.cpu.terms.function_rows import copy_row, function_row
from cnnsim.backends.cpu.terms.groups import Layers, StageTable, Surround, TermArrays, TermPlanes
from cnnsim.backends.cpu.terms.layout import HELD, STAGE, term_layout
from cnnsim.backends.cpu.terms.rows import add_terms, load_cells
from cnnsim.backends.cpu.terms.single import differs, discrete_row, euler_row, largest_rate
from cnnsim.backends.cpu.terms.stage import begin, go_on
from cnnsim.backends.cpu.tiles.grid import Area
from cnnsim.backends.cpu.tiles.scratch import fill, load_bits
from cnnsim.support import Array

SIGN = int(FunctionCode.SIGN)
DRIVE, DISCRETE, STEP, CHECK = map(int, TaskCode)


def step_tile(
    function: int, task: int, number: int, planes: TermPlanes, how: Layers, stages: StageTable,
    characteristic: Any, field: TermArrays, edge: Surround, g: int, area: Area, width: int, low: int, scratch: Array,
    same: Array, found: Array,
) -> None:  # fmt: skip
    """Do a task of `loops.advance` with the cells of ``area`` in all layers of grid g.

    ``function`` is the address of `functions`. ``width`` are the most columns that come
    with a tile; ``low`` the rows of a low torus, else 0. For ``same`` see `add_terms`. ``found`` gets the largest rate
    or change of each layer, and after those whether a row differs from that of two steps ago.
    """
    _, layers, rows, cols = planes[0].shape
    start, states, inputs, w, mask = bare(planes[0]), bare(planes[1]), bare(planes[2]), bare(planes[3]), planes[4]
    kept, masked, words = planes[1].shape[0], mask.size > 0, uncounted(mask)
    gains, limited = how
    table, ahead, keeps = stages
    counted, terms, taps, weights, numbers = field
    kind, places, at_places, values, of_kind = characteristic
    of_function, channels, gains = bare(of_kind), bare(counted), bare(gains)
    parts = channels, bare(terms), bare(taps), bare(weights), bare(numbers)
    scheme = bare(table), bare(ahead), keeps
    r, code, of_input, of_state = edge
    levels = ahead.size if task == STEP else 1
    at = term_layout(scratch, levels, keeps, layers, channels.size, r, low, width)
    scratch, same = bare(scratch), bare(same)
    layer_cells, channel_cells = at.live * at.stride, (at.ring + 1) * at.stride
    apart, level_cells = layers * layer_cells, channels.size * channel_cells
    wraps = code == PERIODIC and not low
    reach = 0 if low else levels * r
    lo, hi, top, bottom = area.c0 - reach, area.c1 + reach, area.r0 - reach, area.r1 + reach
    if not wraps:
        lo, hi, top, bottom = max(lo, 0), min(hi, cols), max(top, 0), min(bottom, rows)
    n, inner, wanted = hi - lo, area.c0 - lo, area.c1 - area.c0
    sides = not wraps and lo == 0, not wraps and hi == cols
    size, of_grid = start.size, g * layers * rows * cols
    now, at_now = (start, of_grid) if number == 0 else (states, number % kept * size + of_grid)
    last, at_last = (start, of_grid) if number <= 1 else (states, (number - 1) % kept * size + of_grid)
    at_next = (number + 1) % kept * size + of_grid
    drive, spare, held = at.work, at.work + at.stride, at.work + 2 * at.stride
    fill(scratch, at.work + 4 * at.stride, n, 0)
    for m in range(levels * channels.size):
        constant = of_input if channels[m % channels.size]["plane"] >= 0 else of_state
        fill(scratch, at.channels + (m + 1) * channel_cells - at.stride - r, n + 2 * r, constant)
    lines = np.empty(2 * r + 1, np.int64)
    for base in range(top, area.r1 + levels * at.lag):
        for level in range(levels + 1):
            i, margin = base - level * at.lag, (levels - level) * r
            if i < max(area.r0 - margin, top) or i >= min(area.r1 + margin, bottom):
                continue
            slot, live = (i - top) % at.ring, at.sets + (i - top) % at.live * at.stride
            if level > 0:
                find_lines(lines, i, slot, rows, low, code, at)
            for layer in range(layers if level > 0 or levels > 1 else 0):
                x, of_layer = live + layer * layer_cells, layer * rows * cols
                if level == 0:
                    load_cells(now, at_now + of_layer, rows, cols, i, lo, n, scratch, x)
                    if masked:
                        load_bits(words[g * layers + layer], i, lo, n, cols, scratch, x + HELD * apart, n)
                    begin(scratch, same, x, apart, n, limited, masked)
                    continue
                load_cells(w, of_grid + of_layer, rows, cols, i, lo, n, scratch, drive)
                of_level = at.channels + (level - 1) * level_cells
                add_terms(function, scratch, same, (at.work, at.stride), (of_level, channel_cells), lines, layer,
                              parts, (i, lo, n, rows, cols))  # fmt: skip
                if level < levels or levels > 1:
                    go_on(scratch, same, drive, spare, x, apart, n, level - 1, scheme, gains[layer], limited, masked)
                if level < levels:
                    continue
                cell, to = of_layer + i * cols + area.c0, drive + inner
                if levels > 1:
                    copy_row(states, at_next + cell, scratch, to, wanted)
                    continue
                if masked:
                    load_bits(words[g * layers + layer], i, area.c0, wanted, cols, scratch, held, wanted)
                if task == DRIVE:
                    copy_row(w, of_grid + cell, scratch, to, wanted)
                elif task == STEP:
                    euler_row(states, at_next + cell, scratch, to, now, at_now + cell, scratch, held, wanted,
                              gains[layer], limited, masked)  # fmt: skip
                elif task == CHECK:
                    rate = largest_rate(scratch, to, now, at_now + cell, scratch, held, wanted, limited, masked)
                    found[layer] = max(found[layer], rate)
                else:
                    function_row(function, scratch, spare, same, to, wanted, kind, places, at_places, values,
                                 of_function)  # fmt: skip
                    change = discrete_row(scratch, spare, scratch, to, now, at_now + cell, same, held, wanted,
                                          kind == SIGN, masked)  # fmt: skip
                    found[layer] = max(found[layer], change)
                    if differs(scratch, spare, last, at_last + cell, wanted):
                        found[layers] = 1
                    copy_row(states, at_next + cell, scratch, spare, wanted)
            if level < levels:
                state = live + STAGE * apart if levels > 1 else NOTHING
                row = at.channels + level * level_cells + slot * at.stride
                fill_channels(
                    function, scratch, same, state, row, (spare, channel_cells, layer_cells), (start, states, inputs),
                    (number, ahead[level], kept), channels, (kind, places, at_places, values, of_function),
                    (g, layers, rows, cols), (i, lo, n), sides, edge,
                )  # fmt: skip
