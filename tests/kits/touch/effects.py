"""Batches of values and scenes for tests of effects."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile.core.frame import TaxelArray
from tactile.simulator.batch import Batch
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.scene.scene import Scene

ARRAY = TaxelArray("a", 3, 4, 3e-4, 2e-4)

FULL = 0.1


def batches(values: NDArray[np.float64], t: Any, cut: int = 10**9) -> Iterator[Batch]:
    """Yield values (n, rows, cols, 3) at times t as batches of at most `cut` frames."""
    array = TaxelArray("a", values.shape[1], values.shape[2], 3e-4, 2e-4)
    for start in range(0, len(t), cut):
        here = slice(start, min(start + cut, len(t)))
        number = np.arange(here.start, here.stop)
        yield Batch(array, 1.0, FULL, t[here], number, values[here].copy(), np.ones(values[here].shape[:3], bool))


def through(effect: Any, values: NDArray[np.float64], t: Any = None, seed: int = 1, cut: int = 10**9) -> Any:
    times = np.arange(len(values)) * 0.01 if t is None else t
    return np.concatenate([batch.values for batch in effect(batches(values, times, cut), np.random.default_rng(seed))])


def scene(**changes: Any) -> Scene:
    path = np.array(
        [(0.0, -3e-4, 1e-4, 0.002, 0.0, 0.0), (0.5, 0, 0, 0.004, 0.001, 0.02), (1.0, 3e-4, 0, -0.003, 0, 0.01)]
    )
    return replace(Scene("s", 100.0, 1.0, 2.4e6, (ARRAY,), (MovingLoad(0, path),)), **changes)
