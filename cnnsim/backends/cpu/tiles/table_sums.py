"""Weighted sums of short tables of differences of neighbours, in one pass over a row.

Difference, table and product would else be three passes. The rounding is the same: total + weight * f(v - less), or
total + weight * f(v - less) * (v - less) where the sum is ``squared``.
"""

from typing import Any

from cnnsim.backends.cpu.compiled import helper
from cnnsim.backends.cpu.tiles.functions import line_from, step_beyond
from cnnsim.support import Array

MOST_PLACES = 5
"""Places of a short table: the tables that MATCNN and CANDY ship rarely have more."""


@helper
def _add_one_step(total: Array, weight: float, v: Array, less: Array, edge: float, low: float, high: float) -> None:
    below, above = weight * low, weight * high
    for j in range(total.size):
        total[j] += above if v[j] - less[j] > edge else below


@helper
def _add_steps(
    total: Array, weight: float, v: Array, less: Array, squared: bool, start: float, edges: Any, heights: Any
) -> None:
    (e0, e1, e2, e3, e4), (f0, f1, f2, f3, f4) = edges, heights
    for j in range(total.size):
        p = v[j] - less[j]
        f = f0 if p > e0 else start
        f = f1 if p > e1 else f
        f = f2 if p > e2 else f
        f = f3 if p > e3 else f
        f = f4 if p > e4 else f
        total[j] += weight * (f * p if squared else f)


@helper
def _add_lines(total: Array, weight: float, v: Array, less: Array, squared: bool, lines: Any, ends: Any) -> None:
    (e0, f0, r0), (e1, f1, r1), (e2, f2, r2), (e3, f3, r3) = lines
    start, last, end = ends
    for j in range(total.size):
        p = v[j] - less[j]
        f = f0 + r0 * (p - e0) if p > e0 else start
        f = f1 + r1 * (p - e1) if p > e1 else f
        f = f2 + r2 * (p - e2) if p > e2 else f
        f = f3 + r3 * (p - e3) if p > e3 else f
        f = end if p > last else f
        total[j] += weight * (f * p if squared else f)


@helper
def add_table(
    steps: bool, squared: bool, total: Array, weight: float, v: Array, less: Array, at: Array, values: Array
) -> None:
    """Add weight * f(v - less), ``squared``: times (v - less), to a row; f has `MOST_PLACES` places at most."""
    if steps and at.size == 1 and not squared:
        _add_one_step(total, weight, v, less, at[0], values[0], values[1])
    elif steps:
        e0, f0 = step_beyond(at, values, 0)
        e1, f1 = step_beyond(at, values, 1)
        e2, f2 = step_beyond(at, values, 2)
        e3, f3 = step_beyond(at, values, 3)
        e4, f4 = step_beyond(at, values, 4)
        _add_steps(total, weight, v, less, squared, values[0], (e0, e1, e2, e3, e4), (f0, f1, f2, f3, f4))
    else:
        one, two, three = line_from(at, values, 0), line_from(at, values, 1), line_from(at, values, 2)
        ends = values[0], at[at.size - 1], values[at.size - 1]
        _add_lines(total, weight, v, less, squared, (one, two, three, line_from(at, values, 3)), ends)
