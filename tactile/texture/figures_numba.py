"""Update of the texture figures for one frame, compiled; `tactile.texture.figures.Texture` has the formulas."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit


@kept_njit(error_model="numpy")
def step(values, floor, streak, block, tails, grown, head, figures):  # type: ignore[no-untyped-def]  # typed at the call
    """Process one frame (rows, cols, 3) as sample ``head`` of the block; write ``figures`` (2, rows, cols) in place.

    ``block`` (T, rows, cols) samples; ``tails`` (T + 1, 2, rows, cols) mean and sum of squared deviations of the
    samples of the last block from k on; ``grown`` (2, rows, cols) the same of the samples of this block so far;
    ``streak`` number of consecutive samples that count.
    """
    window, rows, cols = block.shape
    last = head + 1 == window
    for i in range(rows):
        for j in range(cols):
            normal = abs(values[i, j, 2])
            mu = math.hypot(values[i, j, 0], values[i, j, 1]) / normal
            counts = normal > floor and normal < np.inf and mu < np.inf
            streak[i, j] = streak[i, j] + 1 if counts else 0
            block[head, i, j] = mu if counts else 0.0
            grown[0, i, j], grown[1, i, j] = _added(grown[0, i, j], grown[1, i, j], head, block[head, i, j])
            a, b = tails[head + 1, 0, i, j], grown[0, i, j]
            n_b = head + 1
            n_a = window - n_b
            mean = a + (b - a) * (n_b / window)
            squares = tails[head + 1, 1, i, j] + grown[1, i, j] + (b - a) * (b - a) * (n_a * n_b / window)
            figures[0, i, j] = figures[1, i, j] = np.nan
            if streak[i, j] >= window:
                figures[0, i, j] = mean
                figures[1, i, j] = 100 * math.sqrt(squares / (window - 1)) / mean if mean > 0 else 0.0
            if last:  # sum the full block from its end; the head starts again
                mean = squares = 0.0
                for k in range(window - 1, -1, -1):
                    mean, squares = _added(mean, squares, window - 1 - k, block[k, i, j])
                    tails[k, 0, i, j], tails[k, 1, i, j] = mean, squares
                grown[0, i, j] = grown[1, i, j] = 0.0


@kept_helper(error_model="numpy")
def _added(mean, squares, count, sample):  # type: ignore[no-untyped-def]
    """Add one sample to the mean and squares of ``count`` samples (Welford)."""
    away = sample - mean
    mean += away / (count + 1)
    return mean, squares + away * (sample - mean)
