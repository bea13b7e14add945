"""Forward sensitivities of linear templates: the tangent of each stage of a scheme, in NumPy.

Brendel, Roska and Bartfai, Neural Processing Letters 16 (2002) 111: they obey equations of the same form as the states.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cnnsim.network.boundary import correlate
from cnnsim.network.weights import all_taps
from cnnsim.support import Array
from cnnsim.task import Task


@dataclass(frozen=True)
class Direction:
    """Changes of A, B, z and of the planes bias, u and x(0)."""

    A: Array
    B: Array
    z: float
    bias: Array
    input: Array
    state: Array


def _moved(plane: Array, weights: Array, change: Array, by: Array, boundary: Any, constant: float) -> Array:
    """Return the change of weights * plane."""
    same = correlate(plane, all_taps(by), boundary, constant, np.zeros_like(plane))
    return correlate(change, all_taps(weights), boundary, 0.0, same)


def end_and_tangent(task: Task, steps: int, way: Direction) -> tuple[Array, Array]:
    """Return the state after the steps, and its derivative in a direction."""
    plan, template, boundary = task.plan, task.plan.template, task.plan.boundary
    assert plan.scheme is not None
    h, limited = plan.scheme.gain(plan.step), plan.cell == "full-range"
    free = np.ones(task.state.shape, bool) if task.mask is None else ~task.mask
    u, bias = task.input, np.zeros_like(task.state) if task.bias is None else task.bias
    assert isinstance(u, np.ndarray)
    assert isinstance(bias, np.ndarray)
    w = correlate(u, all_taps(template.B), boundary, boundary.u, np.zeros_like(u)) + template.z + bias
    dw = _moved(u, template.B, way.input, way.B, boundary, boundary.u) + way.z + way.bias
    x, dx = task.state, way.state

    def limit(v: Array, dv: Array) -> tuple[Array, Array]:
        return (np.clip(v, -1, 1), np.where(np.abs(v) < 1, dv, 0.0)) if limited else (v, dv)

    for _ in range(steps):
        rates: list[tuple[Array, Array]] = []
        for number, row in enumerate(plan.scheme.a):
            v, dv = x, dx
            if number:
                moves = [sum(h * weight * k[part] for weight, k in zip(row, rates, strict=True)) for part in (0, 1)]
                v, dv = (
                    np.where(free, new, old)
                    for new, old in zip(limit(x + moves[0], dx + moves[1]), (x, dx), strict=True)
                )
            y, dy = np.clip(v, -1, 1), np.where(np.abs(v) <= 1, dv, 0.0)
            k = correlate(y, all_taps(template.A), boundary, boundary.y, w) - v
            dk = _moved(y, template.A, dy, way.A, boundary, boundary.y) + dw - dv
            rates.append((np.where(free, k, 0), np.where(free, dk, 0)))
        after = [
            old + sum(h * b * k[part] for b, k in zip(plan.scheme.b, rates, strict=True))
            for part, old in ((0, x), (1, dx))
        ]
        limited_after = limit(*after)
        x, dx = np.where(free, limited_after[0], x), np.where(free, limited_after[1], dx)
    return x, dx
