"""Cell models: the state equation, its rate, and the closed form of uncoupled cells.

A cell leaks towards zero and is driven by the outputs and inputs of its neighbours. With w = B*u + z (+ bias map):

    dx/dt = -x + A*y + w,        y = f(x) = (|x + 1| - |x - 1|) / 2 = clip(x, -1, 1)

Time is counted in time constants. The cell models:

* ``chua-yang``: the output is clipped, the state runs free (|x| <= |z| + sum|A| + sum|B|);
* ``full-range``: the state is limited to [-1, 1], and y = x. A numerical step (and each of its stages) beyond a limit
  ends on it;
* ``discrete-time``: y(k + 1) = f(A*y(k) + w), f the sign unless another characteristic is asked for. All cells change
  at once, one step is one time constant, and the state is the output. A drive of exactly 0 keeps the old output (so a
  cell that starts at 0 stays there until its drive is not 0). Harrer and Nossek, "Discrete-time cellular neural
  networks", Int. J. Circuit Theory Appl. 20 (1992) 453.
"""

from typing import Literal

import numpy as np

from cnnsim.support import Array

CellModel = Literal["chua-yang", "full-range", "discrete-time"]


def output(x: Array) -> Array:
    """Return y = clip(x, -1, 1)."""
    return np.clip(x, x.dtype.type(-1), x.dtype.type(1))


def rate(drive: Array, x: Array, model: CellModel) -> Array:
    """Return dx/dt for the drive A*y + w; in the full-range model it is 0 for a cell driven beyond its limit."""
    change = drive - x
    if model == "full-range":
        stopped = ((x >= 1) & (change > 0)) | ((x <= -1) & (change < 0))
        change = np.where(stopped, change.dtype.type(0), change)
    return change


def uncoupled_state(x0: Array, s: Array, a: float, t: float, model: CellModel) -> Array:
    """Return the exact state x(t) of uncoupled cells: dx/dt = -x + a f(x) + s. ``t`` may be infinite.

    A single cell moves monotonically through at most three pieces of f: out of saturation, through |x| <= 1, into the
    next saturation. Chua and Roska, "Cellular Neural Networks and Visual Computing", ch. 2-3.

    Arguments: ``x0``, ``s`` float arrays of one shape; ``a`` the centre of A; ``t`` in time constants.
    """
    with np.errstate(all="ignore"):  # np.where computes both sides; the unused one may overflow
        if model == "full-range":
            return _through_linear(x0, s, a, np.full_like(x0, t), limited=True)
        side = np.where(x0 < 0, -1.0, 1.0)
        size, push = np.abs(x0), s * side
        target = a + push
        decayed = target + (size - target) * np.exp(-t)
        until_one = np.where(target < 1, np.log((size - target) / (1 - target)), np.inf)
        leaves = (size > 1) & (until_one < t)
        rest_of_time = np.where(leaves, t - until_one, t)
        inside = _through_linear(np.where(leaves, 1.0, size), push, a, rest_of_time, limited=False)
        return side * np.where((size > 1) & ~leaves, decayed, inside)


def _through_linear(x: Array, s: Array, a: float, t: Array, *, limited: bool) -> Array:
    """Return the state after times t from |x| <= 1, into the next saturation (or to the limit) if it is reached."""
    rate = (a - 1) * x + s
    ahead = np.where(rate < 0, -1.0, 1.0)
    x, s, rate = x * ahead, s * ahead, np.abs(rate)
    rate_at_one = (a - 1) + s
    if a == 1:
        moved = rate * t
        until_one = (1 - x) / rate
    else:
        moved = rate * np.expm1((a - 1) * t) / (a - 1)
        until_one = np.log1p((a - 1) * (1 - x) / rate) / (a - 1)
    reaches = (rate > 0) & (rate_at_one > 0) & (until_one <= t)
    left = np.where(np.isinf(t), 0.0, np.exp(-(t - until_one)))  # near the separatrix until_one may round to infinity
    beyond = np.ones_like(x) if limited else (a + s) + (1 - a - s) * left
    return ahead * np.where(reaches, beyond, np.where(rate == 0, x, x + moved))  # a NaN stays NaN
