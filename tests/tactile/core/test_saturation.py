"""Saturation: the ends of a sensor's range, learned from noisy readings that stop at one value."""

import numpy as np

from cnnsim.support import Floats
from tactile.core.saturation import LEAST, Saturation


def marked(signal: Floats, noise: float, end: float = np.inf, step: float = 0.0) -> list[bool]:
    """Return whether the taxel counts as saturated after each frame of the normal reading ``signal`` (n,)."""
    random, saturation = np.random.default_rng(1), Saturation((1, 1))
    jitter, found = np.full((1, 1, 3), noise), []
    for value in signal:
        read = np.array([[[0.0, 0.0, value]]]) + random.normal(size=(1, 1, 3)) * noise
        read = np.clip(read if step == 0 else np.rint(read / step) * step, -end, end)
        found.append(saturation(read, jitter) is not None)
    return found


PRESS = -np.concatenate([np.zeros(50), np.linspace(0, 1, 20), np.ones(200), np.linspace(1, 0, 20), np.zeros(50)])


def test_readings_clipped_at_one_value_are_saturated() -> None:
    found = marked(PRESS, 1e-3, end=0.7)
    at = np.abs(PRESS) > 0.71
    assert all(np.array(found)[at][LEAST:])
    assert not any(np.array(found)[~at])
    assert any(marked(PRESS, 1e-3, end=0.7, step=1e-4))  # also with converter steps


def test_a_constant_load_is_not_saturated() -> None:
    for level in np.linspace(0.9, 1.0, 21):
        for step in (0.0, 1e-3, 3e-3, 0.01):  # from half to five times the noise
            assert not any(marked(level * PRESS, 2e-3, step=step))


def test_missing_readings_are_ignored() -> None:
    saturation = Saturation((1, 2))
    for _ in range(3 * LEAST):
        assert saturation(np.full((1, 2, 3), np.nan), np.full((1, 2, 3), 1e-3)) is None
