"""The exact transient of a linear template on a small grid, by dense matrix exponentials and kinks found by bisection.

Within one pattern of saturated cells the network is linear, x' = J x + c, and its flow is expm of the matrix
[[J, c], [0, 0]] (Hale and Lin; Chua and Yang 1988, eq. 2). Cells are coupled one by one, by the definition of the
boundary; nothing of this is shared with the product. ``mpmath`` gives as many digits as one likes.
"""

from typing import Any

import mpmath
import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from cnnsim.support import Floats


def coupling(A: Floats, shape: tuple[int, int], boundary: Any) -> tuple[Floats, Floats]:
    """The matrix (cells, cells) of A, and what virtual cells of constant output drive."""
    rows, cols = shape
    matrix, constant, r = np.zeros((rows * cols, rows * cols)), np.zeros(rows * cols), len(A) // 2
    for i in range(rows):
        for j in range(cols):
            for k in range(-r, r + 1):
                for l in range(-r, r + 1):
                    p, q, weight = i + k, j + l, A[k + r, l + r]
                    if boundary.kind == "periodic":
                        p, q = p % rows, q % cols
                    elif boundary.kind == "zero-flux":
                        p, q = min(max(p, 0), rows - 1), min(max(q, 0), cols - 1)
                    if 0 <= p < rows and 0 <= q < cols:
                        matrix[i * cols + j, p * cols + q] += weight
                    else:
                        constant[i * cols + j] += weight * boundary.y
    return matrix, constant


def exact(A: Floats, w: Floats, x0: Floats, boundary: Any, duration: float, mask: Any = None) -> Floats:
    """The state at ``duration``; w is the drive B*u + z of each cell, both planes (rows, cols)."""
    matrix, constant = coupling(A, x0.shape, boundary)
    c = constant + w.ravel()
    free = np.ones(x0.size) if mask is None else 1.0 - np.asarray(mask, float).ravel()
    x, t = x0.ravel().astype(float), 0.0
    inside = np.abs(x) < 1
    while t < duration:
        J = free[:, None] * (matrix * inside - np.eye(x.size))
        now = free * (c + matrix @ np.where(inside, 0.0, np.sign(x)))
        generator = np.block([[J, now[:, None]], [np.zeros((1, x.size + 1))]])
        step = min(0.02, duration - t)
        ahead = (expm(generator * step) @ np.append(x, 1.0))[:-1]
        if np.array_equal(np.abs(ahead) < 1, inside):
            x, t = ahead, t + step
            continue
        low, high = 0.0, step  # the first change of the pattern, by bisection
        while high - low > 1e-15:
            middle = (low + high) / 2
            there = (expm(generator * middle) @ np.append(x, 1.0))[:-1]
            low, high = (middle, high) if np.array_equal(np.abs(there) < 1, inside) else (low, middle)
        x, t = (expm(generator * high) @ np.append(x, 1.0))[:-1], t + high
        inside = np.abs(x) < 1
    return x.reshape(x0.shape)


def by_scipy(A: Floats, w: Floats, x0: Floats, boundary: Any, duration: float) -> Floats:
    """The same by DOP853 with the tightest tolerance, which sees the kinks as any other bend."""
    matrix, constant = coupling(A, x0.shape, boundary)
    drive = constant + w.ravel()
    found = solve_ivp(
        lambda _t, x: matrix @ x.clip(-1, 1) + drive - x, (0.0, duration), x0.ravel(), method="DOP853",
        rtol=1e-13, atol=1e-14, max_step=0.02,
    )  # fmt: skip
    return found.y[:, -1].reshape(x0.shape)


def in_many_digits(A: Floats, w: Floats, x0: Floats, boundary: Any, duration: float, digits: int = 40) -> Floats:
    """The same in ``digits`` digits, for a handful of cells: Taylor series in mpmath between bisected kinks."""
    with mpmath.workdps(digits):
        rough, constant = coupling(A, x0.shape, boundary)
        n = x0.size
        matrix = [[mpmath.mpf(float(v)) for v in row] for row in rough]
        drive = [mpmath.mpf(float(a)) + mpmath.mpf(float(b)) for a, b in zip(constant, w.ravel(), strict=True)]
        x, t, end = [mpmath.mpf(float(v)) for v in x0.ravel()], mpmath.mpf(0), mpmath.mpf(float(duration))

        def series(state: list[Any], inside: list[bool]) -> list[list[Any]]:
            terms = [state]
            y = [v if i else mpmath.sign(v) for v, i in zip(state, inside, strict=True)]
            terms.append([mpmath.fdot(matrix[i], y) + drive[i] - state[i] for i in range(n)])
            while len(terms) < 3 * digits // 2:
                last = terms[-1]
                y = [v if i else mpmath.mpf(0) for v, i in zip(last, inside, strict=True)]
                terms.append([(mpmath.fdot(matrix[i], y) - last[i]) / len(terms) for i in range(n)])
            return terms

        def at(terms: list[list[Any]], s: Any) -> list[Any]:
            powers = [s**k for k in range(len(terms))]
            return [mpmath.fdot([term[i] for term in terms], powers) for i in range(n)]

        inside = [abs(v) < 1 for v in x]
        while t < end:
            terms, s = series(x, inside), min(mpmath.mpf(1) / 64, end - t)
            ahead = at(terms, s)
            if [abs(v) < 1 for v in ahead] != inside:
                low, high = mpmath.mpf(0), s
                while high - low > mpmath.mpf(10) ** (3 - digits):
                    middle = (low + high) / 2
                    same = [abs(v) < 1 for v in at(terms, middle)] == inside
                    low, high = (middle, high) if same else (low, middle)
                s, ahead = high, at(terms, high)
                inside = [abs(v) < 1 for v in ahead]
            x, t = ahead, t + s
        return np.array([float(v) for v in x]).reshape(x0.shape)
