"""Weights of an array's signals, from the noise of each: made once for all the frames that are located with them."""

from typing import NamedTuple

import numpy as np

from cnnsim.support import Floats, InputError


class Weights(NamedTuple):
    """``noise``: the median standard deviation of the signals, None where none is known; ``scale`` (n, 3): that over
    each signal's own, ``trust`` (n,): the least of a taxel's.
    """

    noise: float | None
    scale: Floats
    trust: Floats


def weigh(noise: Floats | float | None, shape: tuple[int, int]) -> Weights:
    """Return the weights for a noise of one number or (rows, cols, 3), as `localise` takes it; alike for None.

    Raises:
        InputError: noise that does not have the array's shape, or is not positive.
    """
    count = shape[0] * shape[1]
    alike = np.ones((count, 3)), np.ones(count)
    if noise is None:
        return Weights(None, *alike)
    if np.shape(noise) not in ((), (*shape, 3)) or not np.min(noise) > 0:
        wanted = f"positive numbers, one or {(*shape, 3)}, wanted"
        raise InputError(f"noise of shape {np.shape(noise)} from {np.min(noise):g} N on; {wanted}")
    if not np.ndim(noise):
        return Weights(float(noise), *alike)
    sigma = np.reshape(noise, (-1, 3))
    typical = float(np.median(sigma))
    return Weights(typical, typical / sigma, (typical / sigma).min(axis=1))
