"""Tables of few places, of differences of neighbours: looked up, weighed and added to a row in a single pass over it.

Each value would else be written and read again three times, as a difference, as what the table makes of it and as a
product. What is rounded stays the same: ``total + weight * f(v - less)``, or with ``v - less`` as a further factor.
"""

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.terms.function_rows import line_from, step_beyond
from cnnsim.support import Array

MOST_PLACES = 5
"""What the loops below have written out: a table that MATCNN or CANDY ship rarely has more."""


@helper
def _add_steps(
    total: Array, at_total: int, weight: float, v: Array, at_v: int, less: Array, at_less: int, n: int, squared: bool,
    start: float, e0: float, e1: float, e2: float, e3: float, e4: float, f0: float, f1: float, f2: float, f3: float,
    f4: float,
) -> None:  # fmt: skip
    """Add weight * f, where f is ``start``, or f0 .. f4 beyond e0 .. e4, which grow."""
    total, v, less = total[at_total : at_total + n], v[at_v : at_v + n], less[at_less : at_less + n]
    for j in range(n):
        p = v[j] - less[j]
        f = f0 if p > e0 else start
        f = f1 if p > e1 else f
        f = f2 if p > e2 else f
        f = f3 if p > e3 else f
        f = f4 if p > e4 else f
        total[j] += weight * (f * p if squared else f)


@helper
def _add_one_step(
    total: Array, at_total: int, weight: float, v: Array, at_v: int, less: Array, at_less: int, n: int, edge: float,
    low: float, high: float,
) -> None:  # fmt: skip
    """Add weight * f for a step at a single edge, which is what medians and contours are made of."""
    total, v, less = total[at_total : at_total + n], v[at_v : at_v + n], less[at_less : at_less + n]
    below, above = weight * low, weight * high
    for j in range(n):
        total[j] += above if v[j] - less[j] > edge else below


@helper
def _add_two_lines(
    total: Array, at_total: int, weight: float, v: Array, at_v: int, less: Array, at_less: int, n: int, squared: bool,
    start: float, e0: float, e1: float, f0: float, f1: float, r0: float, r1: float, last: float, end: float,
) -> None:  # fmt: skip
    """Do what `_add_lines` does for the two lines of a hat or a ramp, which is what diffusion is told by."""
    total, v, less = total[at_total : at_total + n], v[at_v : at_v + n], less[at_less : at_less + n]
    for j in range(n):
        p = v[j] - less[j]
        f = f0 + r0 * (p - e0) if p > e0 else start
        f = f1 + r1 * (p - e1) if p > e1 else f
        f = end if p > last else f
        total[j] += weight * (f * p if squared else f)


@helper
def _add_lines(
    total: Array, at_total: int, weight: float, v: Array, at_v: int, less: Array, at_less: int, n: int, squared: bool,
    start: float, e0: float, e1: float, e2: float, e3: float, f0: float, f1: float, f2: float, f3: float, r0: float,
    r1: float, r2: float, r3: float, last: float, end: float,
) -> None:  # fmt: skip
    """Add weight * f, where f is ``start``, or f0 + r0 (p - e0) beyond e0, and so on, and ``end`` beyond ``last``."""
    total, v, less = total[at_total : at_total + n], v[at_v : at_v + n], less[at_less : at_less + n]
    for j in range(n):
        p = v[j] - less[j]
        f = f0 + r0 * (p - e0) if p > e0 else start
        f = f1 + r1 * (p - e1) if p > e1 else f
        f = f2 + r2 * (p - e2) if p > e2 else f
        f = f3 + r3 * (p - e3) if p > e3 else f
        f = end if p > last else f
        total[j] += weight * (f * p if squared else f)


@helper
def add_table(
    steps: bool, squared: bool, total: Array, at_total: int, weight: float, v: Array, at_v: int, less: Array,
    at_less: int, n: int, places: int, at: int, values: int, numbers: Array,
) -> None:  # fmt: skip
    """Add weight * f(v - less), or (``squared``) weight * f(v - less) * (v - less), to a row.

    f has at most `MOST_PLACES` places, and ``steps`` or lines between them; see `term_table.Function`.
    """
    start = numbers[values]
    if steps and places == 1 and not squared:
        _add_one_step(total, at_total, weight, v, at_v, less, at_less, n, numbers[at], start, numbers[values + 1])
    elif steps:
        e0, f0 = step_beyond(places, at, values, 0, numbers)
        e1, f1 = step_beyond(places, at, values, 1, numbers)
        e2, f2 = step_beyond(places, at, values, 2, numbers)
        e3, f3 = step_beyond(places, at, values, 3, numbers)
        e4, f4 = step_beyond(places, at, values, 4, numbers)
        _add_steps(total, at_total, weight, v, at_v, less, at_less, n, squared, start, e0, e1, e2, e3, e4, f0, f1, f2,
                   f3, f4)  # fmt: skip
    else:
        lines = places - 1  # beyond the last place is none
        e0, f0, r0 = line_from(lines, at, values, 0, numbers)
        e1, f1, r1 = line_from(lines, at, values, 1, numbers)
        last, end = numbers[at + lines], numbers[values + lines]
        if lines <= 2:
            _add_two_lines(total, at_total, weight, v, at_v, less, at_less, n, squared, start, e0, e1, f0, f1, r0, r1,
                           last, end)  # fmt: skip
            return
        e2, f2, r2 = line_from(lines, at, values, 2, numbers)
        e3, f3, r3 = line_from(lines, at, values, 3, numbers)
        _add_lines(total, at_total, weight, v, at_v, less, at_less, n, squared, start, e0, e1, e2, e3, f0, f1, f2, f3,
                   r0, r1, r2, r3, last, end)  # fmt: skip
