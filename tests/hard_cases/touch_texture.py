"""Hard cases of the running texture figures: 10^8 frames, a burst, against a new sum of each window."""

from functools import cache, partial

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.support import Array, Floats
from cnnsim.support.compiled_loops import kept_njit
from tactile.texture.figures_numba import step
from tests.hard_cases.case import HardCase

WINDOW = 128


@kept_njit()
def _sample(n):  # type: ignore[no-untyped-def]  # numba types it at the call
    """A friction coefficient near 1000 that changes in its last digits, and occasional bursts of 1e6 times that."""
    h = (n * 2654435761) & 0xFFFFFFFF
    h = ((h ^ (h >> 15)) * 2246822519) & 0xFFFFFFFF
    value = 1000.0 + (h >> 8) / 16777216.0
    return value * 1e6 if n % 1000003 == 0 and n > 0 else value


@kept_njit()
def _running(count, window):  # type: ignore[no-untyped-def]
    """Friction and roughness after ``count`` frames of one taxel, and those from running sums."""
    streak, block = np.zeros((1, 1), np.int64), np.zeros((window, 1, 1))
    tails, grown, figures = np.zeros((window + 1, 2, 1, 1)), np.zeros((2, 1, 1)), np.zeros((2, 1, 1))
    values, held = np.zeros((1, 1, 3)), np.zeros(window)
    values[0, 0, 2] = 1.0
    total = squares = 0.0
    head = 0
    for n in range(count):
        mu = _sample(n)
        values[0, 0, 0] = mu
        step(values, 0.0, streak, block, tails, grown, head, figures)
        total += mu - held[head]
        squares += mu * mu - held[head] * held[head]
        held[head] = mu
        head = (head + 1) % window
    mean = total / window
    spread = max(squares - window * mean * mean, 0.0)
    return figures[0, 0, 0], figures[1, 0, 0], mean, 100 / mean * np.sqrt(spread / (window - 1))


@cache
def _figures(count: int) -> Floats:
    """The same, cached for ours and the naive form."""
    return np.array(_running(count, WINDOW))


def _exact(count: int) -> Floats:
    from fractions import Fraction

    samples = [Fraction(float(_sample(n))) for n in range(count - WINDOW, count)]
    mean = sum(samples, Fraction(0)) / WINDOW
    spread = sum((one - mean) ** 2 for one in samples) / (WINDOW - 1)
    return np.array([float(mean), 100 / float(mean) * float(spread) ** 0.5])


def _ours(count: int, _: Backend) -> Array:
    return _figures(count)[:2] / _exact(count)


def _naive(count: int) -> Array:
    return _figures(count)[2:] / _exact(count)


def _case(count: int, words: str, page: bool) -> HardCase:
    why = "running sums accumulate the rounding errors of all frames and of every burst"
    return HardCase(
        words, why, partial(_ours, count), lambda: np.ones(2), 1e-12, 1e-12, partial(_naive, count), page=page
    )


CASES = [_case(200_000, "texture over 2 x 10^5 frames", True), _case(100_000_000, "texture over 10^8 frames", True)]
