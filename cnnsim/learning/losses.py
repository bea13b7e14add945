"""Losses of outputs and states, with their derivatives."""

from collections.abc import Callable
from typing import Any, Literal, get_args

import numpy as np

from cnnsim.network import Characteristic
from cnnsim.support import Array, InputError
from cnnsim.support.values import as_numbers

LossName = Literal["squares", "hinge"]
Loss = LossName | Callable[[Array, Array], tuple[float, Array]]
"""A name, or a function of outputs and targets that returns the loss and its derivative by the outputs."""
DECIDED = 2.0
"""State from which a black cell has no hinge loss: 1 beyond the kink of the output."""


def loss_of(loss: Loss, x: Array, target: Array, f: Characteristic) -> tuple[float, Array]:
    """Return a loss of states and its derivative by the states.

    ``squares``: mean (y - target)^2. ``hinge``: mean max(0, 2 - target x)^2, for targets -1 and 1; it depends on the
    state, so that saturated cells of the wrong colour, whose outputs have the slope 0, have a derivative.
    """
    if loss == "hinge":
        lack = np.maximum(0, DECIDED - target * x)
        return float(np.mean(lack**2, dtype=np.float64)), -2 * target * lack / x.size
    y = f(x)
    if loss == "squares":
        value, by_y = float(np.mean((y - target) ** 2, dtype=np.float64)), 2 * (y - target) / x.size
    elif callable(loss):
        value, by_y = loss(y, target)
        if np.shape(by_y) != y.shape or not np.isscalar(value):
            raise InputError(
                f"loss returned {type(value).__name__} and an array {np.shape(by_y)}; a number and {y.shape} wanted"
            )
    else:
        raise InputError(f"loss {loss!r}; {', '.join(get_args(LossName))}, or a function of (y, target), wanted")
    return float(value), by_y * slope_of(f, x)


def slope_of(f: Characteristic, x: Array) -> Array:
    """Return f'(x), with the inner slope at a kink of clip, and the left one at a place of a table."""
    if f.kind == "tanh":
        return f.slope * (1 - f(x) ** 2)
    if f.kind == "clip":
        return f.slope * (np.abs(f.slope * x) <= 1)
    if f.table is None or f.table.kind == "step":
        return np.zeros_like(x)
    at = np.array(f.table.at)
    rises = np.concatenate([[0.0], np.diff(f.table.values) / np.diff(at), [0.0]])
    return rises[np.searchsorted(at, x, side="left")].astype(x.dtype)


def checked_target(values: Any, shape: tuple[int, ...], name: str = "target") -> Array:
    """Return target outputs of a shape.

    Raises:
        InputError: another shape, values that are not finite or beyond +-1.
    """
    target = as_numbers(name, values).astype(np.float64)
    if target.shape != shape:
        raise InputError(f"{name} has shape {target.shape}, the outputs have {shape}; one shape wanted")
    wrong = ~(np.abs(target) <= 1)
    if wrong.any():
        where = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise InputError(f"{name} holds {target[where]:g} in cell {where}; outputs from -1 to 1 wanted")
    return target
