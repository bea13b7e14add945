"""How a tile of a network of terms lies in a thread's scratch: live rows of planes, rings of rows of channels."""

from typing import NamedTuple

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.terms.rows import WORK_ROWS
from cnnsim.backends.cpu.tiles.rows import PAD
from cnnsim.support import Array

_, HELD, STAGE, TOTAL, RATES = range(5)
"""Sets of live rows of a scheme of some stages, one after the other: of the state, the mask, the stage, the sum that
the step ends with, and the rates of all stages but the last where they are kept."""


class TermLayout(NamedTuple):
    """Where rows of ``stride`` cells begin: ``live`` rows of every set and layer; for every level and channel a
    ``ring`` of rows, and one of what is beyond the grid; and rows that are worked on. Each level has a ``lag`` of so
    many rows behind the one before.
    """

    sets: int
    channels: int
    work: int
    stride: int
    live: int
    ring: int
    lag: int


@helper
def sets_of(levels: int, keeps: bool) -> int:
    """Return how many sets of live rows steps of so many stages have, whose rates are kept or not."""
    return 0 if levels == 1 else RATES + (levels - 1) * keeps


@helper
def term_layout(
    scratch: Array, levels: int, keeps: bool, layers: int, channels: int, r: int, low: int, width: int
) -> TermLayout:
    """Lay the buffers out for rows of at most ``width`` cells; all rows of ``low`` ones (else 0) are there at once."""
    first = ((64 - (scratch.ctypes.data & 63)) & 63) // scratch.itemsize + PAD * ((r + PAD - 1) // PAD)
    stride, live, ring, lag = sizes(levels, r, low, width)
    at_channels = first + sets_of(levels, keeps) * layers * live * stride
    return TermLayout(
        first, at_channels, at_channels + levels * channels * (ring + 1) * stride, stride, live, ring, lag
    )


@helper
def sizes(levels: int, r: int, low: int, width: int) -> tuple[int, int, int, int]:
    """Return the stride, the live rows, the rows of a ring and the lag of a level."""
    # an odd number of vectors, so that rows that are used together do not fight for cache sets
    stride = PAD * (((width + 2 * r + PAD - 1) // PAD) | 1)
    return (stride, low, low, low) if low else (stride, levels * r + 1, 2 * r + 1, r)


@helper
def term_cells(levels: int, keeps: bool, layers: int, channels: int, r: int, low: int, width: int) -> int:
    """Return the size of a thread's scratch."""
    stride, live, ring, _ = sizes(levels, r, low, width)
    rows = sets_of(levels, keeps) * layers * live + levels * channels * (ring + 1) + WORK_ROWS + 1
    return rows * stride + 2 * PAD * ((r + PAD - 1) // PAD + 1)
