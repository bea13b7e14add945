"""The flow of a few cells with any matrix, by dense exponentials from kink to kink, bisected: an independent answer."""

import numpy as np
from scipy.linalg import expm

from cnnsim.support import Array

_LOOKS = 0.02


def dense_flow(A: Array, w: Array, x: Array, duration: float) -> Array:
    """Return x(duration) of dx/dt = -x + A clip(x) + w (cells,).

    No cell is expected to cross a kink twice within `_LOOKS` time constants.
    """
    t = 0.0
    while t < duration - 1e-15:
        piece = np.where(np.abs(x) > 1, np.sign(x), 0.0)
        on = np.abs(np.abs(x) - 1) < 1e-13
        rate = A @ x.clip(-1, 1) + w - x
        piece[on] = np.where(np.sign(x[on]) * rate[on] > 0, np.sign(x[on]), 0.0)
        linear = piece == 0
        J, c = A * linear[None] - np.eye(x.size), A @ piece + w
        whole = np.block([[J, c[:, None]], [np.zeros((1, x.size + 1))]])

        def state(s: float, whole: Array = whole, x: Array = x) -> Array:
            return (expm(whole * s) @ np.append(x, 1.0))[:-1]

        def valid(y: Array, linear: Array = linear, piece: Array = piece) -> bool:
            return bool(np.all(np.where(linear, np.abs(y) <= 1, piece * y >= 1)))

        step = min(_LOOKS, duration - t)
        after = state(step)
        if not valid(after):
            low, high = 0.0, step
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if valid(state(middle)) else (low, middle)
            step = max(high, 1e-15)
            after = state(step)
            near = np.argmin(np.abs(np.abs(after) - 1))
            after[near] = np.sign(after[near])
        x, t = after, t + step
    return x
