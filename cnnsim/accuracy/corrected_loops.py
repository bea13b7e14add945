"""Classical Runge-Kutta steps whose kinks are corrected, compiled; planes are flat, with virtual cells around.

In a step in which the output of a cell j meets -1 or +1, the scheme's sum of the four stages misses the integral of
y_j by O(h^2), which is what brings every fixed step down to order 2. A cubic through the ends of the step, with the
rates there, knows that integral to O(h^3): A(i, j) times the difference is added to each neighbour x_i. Only cells that
meet a kink cost anything, so the order is 3 for the work of the plain scheme, and 4 where no cell saturates.
"""

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit

CHUNK = 512
"""Cells of which the rates are computed at once, in the nearest cache."""
NEAR = 1e-6
"""Of a step, to which a kink is located before the last move of Newton's; the integral feels the square of the rest."""


@kept_helper(error_model="numpy")
def repeat_cells(y, virtual, source):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Give the virtual cells the outputs of those that they stand for."""
    for n in range(virtual.size):
        y[virtual[n]] = y[source[n]]


@kept_helper(error_model="numpy", fastmath={"contract"})
def add_taps(y, offsets, weights, at, to, total):  # type: ignore[no-untyped-def]
    """Add the weighted sum over the neighbours of a chunk of cells, three at once: sums wait for stores."""
    total = total[at:to]
    for n in range(0, offsets.size, 3):
        one, two = y[at + offsets[n] : to + offsets[n]], y[at + offsets[n + 1] : to + offsets[n + 1]]
        three = y[at + offsets[n + 2] : to + offsets[n + 2]]
        a, b, c = weights[n], weights[n + 1], weights[n + 2]
        for i in range(total.size):
            total[i] += a * one[i] + b * two[i] + c * three[i]


@kept_njit(error_model="numpy")
def correlated(y, offsets, weights, first, last, total):  # type: ignore[no-untyped-def]
    """Add the weighted sum over the neighbours of all cells."""
    for at in range(first, last, CHUNK):
        add_taps(y, offsets, weights, at, min(at + CHUNK, last), total)


@kept_helper(error_model="numpy", fastmath={"contract"})
def stage(y, x, drive, free, offsets, weights, at, to, k):  # type: ignore[no-untyped-def]
    """Write the rates of a chunk of cells."""
    for i in range(at, to):
        k[i] = drive[i] - x[i]
    add_taps(y, offsets, weights, at, to, k)
    for i in range(at, to):
        k[i] *= free[i]


@kept_helper(error_model="numpy")
def onward(x, k, h, after, y):  # type: ignore[no-untyped-def]
    """Write x + h k and its output."""
    for i in range(x.size):
        v = x[i] + h * k[i]
        after[i] = v
        v = v if v > -1.0 else -1.0  # as min and max are not, this is vectorised
        y[i] = v if v < 1.0 else 1.0


@kept_helper(error_model="numpy")
def between(c0, c1, c2, c3, low, high):  # type: ignore[no-untyped-def]
    """Return the integral of a clipped cubic over times between which it turns nowhere."""
    a = ((c3 * low + c2) * low + c1) * low + c0
    b = ((c3 * high + c2) * high + c1) * high + c0
    start, end = low, high  # of its linear part
    for level in (-1.0, 1.0):
        rises = b > level
        if (a > level) == rises:
            continue
        left, right, t = low, high, low + (high - low) * (level - a) / (b - a)
        for _ in range(30):  # Newton within halves
            v = ((c3 * t + c2) * t + c1) * t + c0 - level
            if (v > 0) == rises:
                right = t
            else:
                left = t
            d = (3 * c3 * t + 2 * c2) * t + c1
            after = t - v / d if d != 0 else left
            if not left < after < right:
                after = 0.5 * (left + right)
            moved, t = abs(after - t), after
            if moved < NEAR:
                break
        if (level > 0) == rises:
            end = t
        else:
            start = t
    if (a >= 1 and b >= 1) or (a <= -1 and b <= -1):
        return (high - low) * (1.0 if a > 0 else -1.0)
    total = (start - low) * min(max(a, -1.0), 1.0) + (high - end) * min(max(b, -1.0), 1.0)
    total += end * (c0 + end * (c1 / 2 + end * (c2 / 3 + end * c3 / 4)))
    return total - start * (c0 + start * (c1 / 2 + start * (c2 / 3 + start * c3 / 4)))


@kept_njit(error_model="numpy")
def clipped_integral(c0, c1, c2, c3):  # type: ignore[no-untyped-def]
    """Return the integral from 0 to 1 of c0 + c1 t + c2 t^2 + c3 t^3 clipped to -1..1."""
    inner, one, two = c2 * c2 - 3 * c1 * c3, 0.0, 0.0  # where it turns
    if c3 != 0 and inner > 0:
        q = -(c2 + np.sqrt(inner)) if c2 >= 0 else np.sqrt(inner) - c2
        one, two = q / (3 * c3), c1 / q
    elif c3 == 0 and c2 != 0:
        one = -c1 / (2 * c2)
    one, two = min(max(one, 0.0), 1.0), min(max(two, 0.0), 1.0)
    one, two = min(one, two), max(one, two)
    total = between(c0, c1, c2, c3, two, 1.0) if two < 1 else 0.0
    if one > 0:
        total += between(c0, c1, c2, c3, 0.0, one)
    if two > one:
        total += between(c0, c1, c2, c3, one, two)
    return total


@kept_helper(error_model="numpy")
def add_to_neighbours(x, y, real, j, missed, offsets, weights):  # type: ignore[no-untyped-def]
    """Add what was missed of a cell's output to the cells that have it as a neighbour."""
    for n in range(offsets.size):
        i = j - offsets[n]
        if 0 <= i < x.size and real[i]:
            x[i] += weights[n] * missed
            y[i] = min(max(x[i], -1.0), 1.0)


@kept_helper(error_model="numpy")
def farthest(y, real, path, apart):  # type: ignore[no-untyped-def]
    """Return how far outputs are from those that were kept on the path, or what it was before if that is more."""
    for i in range(y.size):
        away = abs(y[i] - path[i]) * real[i]
        apart = away if away > apart else apart
    return apart


@kept_njit(error_model="numpy")
def corrected_steps(  # type: ignore[no-untyped-def]
    planes, real, heads, after, offsets, weights, virtual, source, first, last, h, steps, path, every, kept
):
    """Take the state, ``planes[0]``, through so many steps; ``planes`` (13, padded cells), 1 and 2 are w and free.

    ``real`` marks cells that move; ``heads``, ``after`` list the virtual cells that stand for each cell; ``first`` and
    ``last`` real cell. The outputs after each of the first steps are written to ``kept`` (steps, padded cells).
    Those after every ``every`` steps are held against ``path``, which another run has kept: returns how far apart they
    ever were.
    """
    apart = 0.0
    x, drive, free = planes[0], planes[1], planes[2]
    end, inner = planes[3], planes[4]
    y1, y2, y3, y4, y5 = planes[5], planes[6], planes[7], planes[8], planes[9]
    k1, k, k4 = planes[10], planes[11], planes[12]
    onward(x[first:last], k[first:last], 0.0, end[first:last], y1[first:last])
    repeat_cells(y1, virtual, source)
    met = np.empty(CHUNK, np.int64)
    for step in range(steps):
        for at in range(first, last, CHUNK):
            to = min(at + CHUNK, last)
            stage(y1, x, drive, free, offsets, weights, at, to, k1)
            onward(x[at:to], k1[at:to], h / 2, inner[at:to], y2[at:to])
            for i in range(at, to):  # by hand: an assignment of arrays takes seconds to compile
                end[i] = x[i] + h / 6 * k1[i]
        repeat_cells(y2, virtual, source)
        for at in range(first, last, CHUNK):
            to = min(at + CHUNK, last)
            stage(y2, inner, drive, free, offsets, weights, at, to, k)
            onward(x[at:to], k[at:to], h / 2, inner[at:to], y3[at:to])
            for i in range(at, to):
                end[i] += h / 3 * k[i]
        repeat_cells(y3, virtual, source)
        for at in range(first, last, CHUNK):
            to = min(at + CHUNK, last)
            stage(y3, inner, drive, free, offsets, weights, at, to, k)
            onward(x[at:to], k[at:to], h, inner[at:to], y4[at:to])
            for i in range(at, to):
                end[i] += h / 3 * k[i]
        repeat_cells(y4, virtual, source)
        for at in range(first, last, CHUNK):
            to = min(at + CHUNK, last)
            stage(y4, inner, drive, free, offsets, weights, at, to, k4)
            onward(end[at:to], k4[at:to], h / 6, end[at:to], y5[at:to])
        for i in range(first, last):
            inner[i] = end[i]
        for at in range(first, last, CHUNK):
            to = min(at + CHUNK, last)
            a, b, c, d, e = y1[at:to], y2[at:to], y3[at:to], y4[at:to], y5[at:to]
            kinks = 0
            for i in range(a.size):
                ends = (abs(a[i]) == 1) | (abs(b[i]) == 1) | (abs(c[i]) == 1) | (abs(d[i]) == 1) | (abs(e[i]) == 1)
                met[i] = ends & ((a[i] != b[i]) | (a[i] != c[i]) | (a[i] != d[i]) | (a[i] != e[i]))
                kinks += met[i]
            if not kinks:
                continue
            for i in range(a.size):
                j = at + i
                if not met[i] or not real[j]:
                    continue
                rise, r1, r4 = inner[j] - x[j], h * k1[j], h * k4[j]
                whole = clipped_integral(x[j], r1, 3 * rise - 2 * r1 - r4, r1 + r4 - 2 * rise)
                missed = h * (whole - (a[i] + 2 * b[i] + 2 * c[i] + d[i]) / 6)
                add_to_neighbours(end, y5, real, j, missed, offsets, weights)
                copy = heads[j]
                while copy >= 0:
                    add_to_neighbours(end, y5, real, copy, missed, offsets, weights)
                    copy = after[copy]
        repeat_cells(y5, virtual, source)
        if step < len(kept):
            for i in range(first, last):
                kept[step, i] = y5[i]
        place = (step + 1) // every - 1
        if (step + 1) % every == 0 and place < len(path):
            apart = farthest(y5[first:last], real[first:last], path[place, first:last], apart)
        x, end = end, x
        y1, y5 = y5, y1
    if steps % 2:
        for i in range(first, last):
            planes[0, i] = x[i]
    return apart
