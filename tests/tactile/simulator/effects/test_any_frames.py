"""Effects on frames of arrays of any shape, in any number, however they are cut into pieces, empty ones among them."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tactile.core.frame import TaxelArray
from tactile.simulator.batch import Batch
from tactile.simulator.effects import ORDER, effect_class, make_effect, without
from tests.kits.touch.effects import FULL

ON_FRAMES = [name for name in ORDER if effect_class(name).STAGE == "frames"]
SHAPES = [(1, 1), (1, 5), (8, 8)]


def pieces(values: NDArray[np.float64], t: Any, cuts: Iterable[int]) -> Iterator[Batch]:
    array = TaxelArray("a", values.shape[1], values.shape[2], 1e-3, 1e-3)
    for number in np.split(np.arange(len(t)), list(cuts)):
        part = values[number].copy()
        yield Batch(array, 1.0, FULL, t[number], number, part, np.ones(part.shape[:3], bool))


def through(effect: Any, values: NDArray[np.float64], cuts: Iterable[int] = ()) -> tuple[Any, ...]:
    t = 5.0 + np.arange(len(values)) * 1e-3  # a clock that is running already
    out = list(effect(pieces(values, t, cuts), np.random.default_rng(1)))
    return tuple(np.concatenate([getattr(one, name) for one in out]) for name in ("values", "t", "sequence", "valid"))


@pytest.mark.parametrize("name", ON_FRAMES)
@pytest.mark.parametrize("shape", SHAPES)
def test_any_frames_of_any_array_in_any_pieces(name: str, shape: tuple[int, int]) -> None:
    for frames in (0, 1, 2, 100):
        values = np.random.default_rng(frames).normal(size=(frames, *shape, 3)) * 0.05
        left = through(without(effect_class(name)), values)
        assert left[0].tobytes() == values.tobytes()
        whole = through(make_effect(name), values)
        assert whole[0].shape[1:] == (*shape, 3)
        assert np.isfinite(whole[0]).all()
        for cuts in ((0,), (0, 0, 1, 1, 2), (frames // 3, frames // 3, frames)):  # some of them empty
            for one, other in zip(whole, through(make_effect(name), values, cuts), strict=True):
                assert one.shape == other.shape
                np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-15)
