"""Ends of a sensor's range: learned where noisy readings stop, not where a load is held."""

import numpy as np

from cnnsim.support import Floats
from tactile.core.saturation import LEAST, Saturation


def marked(signal: Floats, noise: float, end: float = np.inf, step: float = 0.0) -> list[bool]:
    """Whether the one taxel is marked after each frame of a normal reading ``signal`` (n,)."""
    random, rails = np.random.default_rng(1), Saturation((1, 1))
    jitter, said = np.full((1, 1, 3), noise), []
    for value in signal:
        read = np.array([[[0.0, 0.0, value]]]) + random.normal(size=(1, 1, 3)) * noise
        read = np.clip(read if step == 0 else np.rint(read / step) * step, -end, end)
        said.append(rails(read, jitter) is not None)
    return said


PRESS = -np.concatenate([np.zeros(50), np.linspace(0, 1, 20), np.ones(200), np.linspace(1, 0, 20), np.zeros(50)])


def test_readings_that_stop_at_one_value_are_at_the_end_of_the_range() -> None:
    said = marked(PRESS, 1e-3, end=0.7)
    at = np.abs(PRESS) > 0.71
    assert all(np.array(said)[at][LEAST:])
    assert not any(np.array(said)[~at])
    assert any(marked(PRESS, 1e-3, end=0.7, step=1e-4))  # converters have steps, too


def test_a_load_that_is_held_is_not() -> None:
    for level in np.linspace(0.9, 1.0, 21):
        for step in (0.0, 1e-3, 3e-3, 0.01):  # half of the noise to five times as much
            assert not any(marked(level * PRESS, 2e-3, step=step))


def test_readings_that_are_missing_count_for_nothing() -> None:
    rails = Saturation((1, 2))
    for _ in range(3 * LEAST):
        assert rails(np.full((1, 2, 3), np.nan), np.full((1, 2, 3), 1e-3)) is None
