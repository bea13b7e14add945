"""Readings that are alike at the end of their range alone: as brute force on sorted lists says."""

from itertools import pairwise

import numpy as np
import pytest

from cnnsim.support import Floats
from tactile.inverse.least_squares.doubt_numba import alike_at_end

NEAR = 1e-6


def by_lists(felt: Floats, scale: Floats) -> int:
    raw = sorted(abs(value) / by for value, by in zip(felt.flat, scale.flat, strict=True) if by > 0 and value != 0)
    end = [value for value in raw if value >= raw[-1] * (1 - NEAR)]
    below = raw[: len(raw) - len(end)]
    pairs = pairwise(below)
    return 0 if len(end) < 2 or any(low >= high * (1 - NEAR) for low, high in pairs) else len(end)


@pytest.mark.parametrize("taxels", [1, 2, 3, 7, 16, 61])
def test_as_sorted_lists_say(taxels: int) -> None:
    rng, told = np.random.default_rng(taxels), set[int]()
    for turn in range(60):
        felt, scale = rng.normal(size=(taxels, 3)), rng.uniform(0.5, 2, (taxels, 3))
        scale[rng.random(felt.shape) < 0.1 * (turn % 3)] = 0
        raw = np.clip(felt, -1, 1) if turn % 2 else np.round(felt, 1 + turn % 4)
        found = alike_at_end(raw * scale, scale, NEAR)
        assert found == by_lists(raw * scale, scale)
        told.add(found)
    assert 0 in told
    assert taxels == 1 or len(told) > 1
