"""Whether planes have settled: the largest |dx/dt|, and which cells are saturated for good (see `euler.settled`)."""

from cnnsim.backends.cpu.euler.settled import saturated
from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.support import Array


@helper
def check_row(drive: Array, x: Array, mask: Array, limited: bool) -> tuple[float, bool]:
    """Return the largest |dx/dt| of a row, and whether each of its free cells is saturated for good."""
    zero, one = x.dtype.type(0), x.dtype.type(1)
    largest = zero
    frozen = True
    for j in range(x.size):
        if mask.size and mask[j]:
            continue
        rate = drive[j] - x[j]
        if limited and ((x[j] >= one and rate > zero) or (x[j] <= -one and rate < zero)):
            rate = zero
        largest = max(largest, abs(rate))
        if not saturated(x[j], drive[j], one):
            frozen = False
    return largest, frozen
