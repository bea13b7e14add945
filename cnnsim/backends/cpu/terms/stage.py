"""Rows of a stage of a network of terms, between its drives and the next stage, or the end of the step.

    k_i = drive of x_i - x_i,    x_i = x + gain (sum of a_ij k_j over j < i),    x <- x + gain (sum of b_i k_i)

Of every row there are `sets <layout.X>`, so many cells apart; rows are given by where that of the state begins.
"""

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.terms.groups import StageTable
from cnnsim.backends.cpu.terms.layout import HELD, RATES, STAGE, TOTAL
from cnnsim.backends.cpu.tiles.row_sums import (
    add_weighted,
    copy_cells,
    keep_held,
    outputs,
    subtract,
    weighted_sum,
)
from cnnsim.backends.cpu.tiles.scratch import fill
from cnnsim.support import Array


@helper
def begin(scratch: Array, same: Array, x: int, apart: int, n: int, limited: bool, masked: bool) -> None:
    """Begin the first stage, which is the state, and the sum that the step ends with. For ``same`` see `add_terms`."""
    fill(scratch, x + TOTAL * apart, n, 0)
    copy_cells(scratch, x + STAGE * apart, same, x, n)
    _stop(scratch, same, x + STAGE * apart, x, apart, n, limited, masked)


@helper
def go_on(
    scratch: Array, same: Array, drive: int, spare: int, x: int, apart: int, n: int, stage: int, stages: StageTable,
    gain: float, limited: bool, masked: bool,
) -> None:  # fmt: skip
    """Go from the row of the drives of a stage to the next stage, or to the end of the step, which replaces the row.

    ``spare`` is a row to work in.
    """
    table, ahead, keeps = stages
    count = ahead.size
    of_stage, total, rates = x + STAGE * apart, x + TOTAL * apart, x + RATES * apart
    subtract(scratch, drive, same, of_stage, n)
    add_weighted(scratch, total, table[count * count + stage], same, drive, n)
    if stage + 1 == count:
        weighted_sum(scratch, drive, same, x, gain, same, total, n)
        _stop(scratch, same, drive, x, apart, n, limited, masked)
        return
    row = (stage + 1) * count
    fill(scratch, spare, n, 0)
    if keeps:
        copy_cells(scratch, rates + stage * apart, same, drive, n)
        for earlier in range(stage + 1):
            add_weighted(scratch, spare, table[row + earlier], same, rates + earlier * apart, n)
    else:
        add_weighted(scratch, spare, table[row + stage], same, drive, n)
    weighted_sum(scratch, of_stage, same, x, gain, same, spare, n)
    _stop(scratch, same, of_stage, x, apart, n, limited, masked)


@helper
def _stop(scratch: Array, same: Array, row: int, x: int, apart: int, n: int, limited: bool, masked: bool) -> None:
    """Keep states within +-1 where they are limited, and as they were where they are held."""
    if limited:
        outputs(scratch, row, scratch, row, n)
    if masked:
        keep_held(scratch, row, same, x + HELD * apart, same, x, n)
