"""Classical Runge-Kutta steps of a linear network with a correction at the kinks of the output, compiled.

Where the output of a cell j reaches -1 or +1 within a step, the sum of the four stages misses the integral of y_j by
O(h^2), which lowers the order of every fixed step to 2. A cubic through both ends of the step, with the rates there,
gives that integral to O(h^3). Adding A(i, j) times the difference to each neighbour i restores order 3.
"""

from cnnsim.support.compiled_loops import kept_helper, kept_njit

PARTS = 8
"""Number of chords in the integral of the cubic: their error is far below that of the cubic."""


@kept_helper(error_model="numpy")
def clip(v):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Return the output of a state."""
    return min(max(v, -1.0), 1.0)


@kept_helper(error_model="numpy")
def primitive(v):  # type: ignore[no-untyped-def]
    """Return the integral of the output from 0 to v."""
    return 0.5 * v * v if abs(v) < 1 else abs(v) - 0.5


@kept_njit(error_model="numpy")
def clipped_integral(c0, c1, c2, c3):  # type: ignore[no-untyped-def]
    """Return the integral from 0 to 1 of c0 + c1 t + c2 t^2 + c3 t^3 clipped to [-1, 1], with `PARTS` chords."""
    total, a = 0.0, c0
    for n in range(1, PARTS + 1):
        t = n / PARTS
        b = ((c3 * t + c2) * t + c1) * t + c0
        if abs(b - a) > 1e-7:
            total += (primitive(b) - primitive(a)) / (b - a)
        else:
            total += clip(0.5 * (a + b))
        a = b
    return total / PARTS


@kept_helper(error_model="numpy")
def product(matrix, taps, y, total):  # type: ignore[no-untyped-def]
    """Write A y to ``total``: from shifted outputs inside the grid, from the sparse rows of A at its edge."""
    at, there, weight = matrix
    offsets, weights, edge = taps
    total[:] = 0.0
    for n in range(offsets.size):
        first, last = max(0, -offsets[n]), min(y.size, y.size - offsets[n])
        here, shifted, w = total[first:last], y[first + offsets[n] : last + offsets[n]], weights[n]
        for i in range(here.size):
            here[i] += w * shifted[i]
    for i in edge:
        total[i] = 0.0
        for n in range(at[i], at[i + 1]):
            total[i] += weight[n] * y[there[n]]


@kept_helper(error_model="numpy")
def rate(matrix, taps, cells, x, y, k):  # type: ignore[no-untyped-def]
    """Write dx/dt of states x with outputs y; ``cells`` (2, cells) are the drive, and 1 where a cell is free."""
    product(matrix, taps, y, k)
    for i in range(x.size):
        k[i] = (k[i] + cells[0, i] - x[i]) * cells[1, i]


@kept_njit(error_model="numpy")
def corrected_steps(matrix, taps, cells, x, h, steps):  # type: ignore[no-untyped-def]
    """Advance the state x (cells,) in place by some steps of length h.

    Arguments: ``matrix`` A as compressed rows; ``taps``: distances in the flat grid and weights of A, and the cells at
    the edge, where virtual cells make them invalid; ``cells`` as of `rate`.
    """
    size = x.size
    y1, y2, y3, y4, end = x.copy(), x.copy(), x.copy(), x.copy(), x.copy()
    k1, k2, k3, k4, missed = x.copy(), x.copy(), x.copy(), x.copy(), x.copy()
    for i in range(size):
        y1[i] = clip(x[i])
    for _ in range(steps):
        rate(matrix, taps, cells, x, y1, k1)
        for i in range(size):
            end[i] = x[i] + h / 2 * k1[i]
            y2[i] = clip(end[i])
        rate(matrix, taps, cells, end, y2, k2)
        for i in range(size):
            end[i] = x[i] + h / 2 * k2[i]
            y3[i] = clip(end[i])
        rate(matrix, taps, cells, end, y3, k3)
        for i in range(size):
            end[i] = x[i] + h * k3[i]
            y4[i] = clip(end[i])
        rate(matrix, taps, cells, end, y4, k4)
        kinks = 0
        for i in range(size):
            end[i] = x[i] + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
            a, b, c, d, e = y1[i], y2[i], y3[i], y4[i], clip(end[i])
            met = (abs(a) == 1) | (abs(b) == 1) | (abs(c) == 1) | (abs(d) == 1) | (abs(e) == 1)
            missed[i] = 0.0
            if met & ((a != b) | (a != c) | (a != d) | (a != e)):
                rise, r1, r4 = end[i] - x[i], h * k1[i], h * k4[i]
                whole = clipped_integral(x[i], r1, 3 * rise - 2 * r1 - r4, r1 + r4 - 2 * rise)
                missed[i] = h * (whole - (a + 2 * b + 2 * c + d) / 6)
                kinks += 1
        if kinks:
            product(matrix, taps, missed, k1)
            for i in range(size):
                end[i] += cells[1, i] * k1[i]
        for i in range(size):
            x[i] = end[i]
            y1[i] = clip(end[i])
