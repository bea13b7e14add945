"""Scratch memory of tiles: where tiles come to lie nothing is left of what the memory held before."""

import numpy as np
import pytest

from cnnsim.backends.cpu.compiled import kernel
from cnnsim.backends.cpu.tiles.rows import PAD, STRIDE
from cnnsim.backends.cpu.tiles.scratch import clear
from cnnsim.support import Array


@kernel
def cleared(scratch: Array, width: int) -> None:
    clear(scratch, width)


@pytest.mark.parametrize("width", [1, 8, 300, STRIDE])
@pytest.mark.parametrize("start", [0, 15])
def test_every_row_is_zero_as_far_as_a_tile_goes(width: int, start: int) -> None:
    """``start``: where the first cache line begins, from which rows are counted; the last row is not whole."""
    scratch = np.full(7 * STRIDE + 5, 1e-40, np.float32)
    cleared(scratch, width)
    rows = scratch[start : start + 6 * STRIDE].reshape(6, STRIDE)
    assert (rows[:, : min(PAD + width + PAD, STRIDE - start)] == 0).all()
    assert (scratch[7 * STRIDE :] == 0).all()
    if width < 300:
        assert (rows[:, width + 4 * PAD : STRIDE - start] != 0).all(), (
            "no more than that: it would take longer than small grids"
        )
