"""Linear separation: weights of maximal margin by linear programming, or a certificate that there are none."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from cnnsim.prototyping.design.rule import Signs, window_numbers
from cnnsim.support import Flags, Floats, Integers

Norm = Literal["sum", "largest"]
"""The norm of a relative margin: the sum of all |weights| and |z|, or the largest of them."""


@dataclass(frozen=True)
class Separator:
    """``weights`` . v + ``bias`` is >= 1 on all black rows v and <= -1 on all white ones: a margin of exactly 1."""

    weights: tuple[Fraction, ...]
    bias: Fraction

    def drive(self, rows: Signs) -> list[Fraction]:
        """Return weights . v + bias for rows (n, d), exactly."""
        return [sum((w if v > 0 else -w for w, v in zip(self.weights, row, strict=True)), self.bias) for row in rows]

    def colours(self, rows: Signs) -> Signs:
        """Return +1 or -1 for rows (n, d)."""
        floats = rows @ np.array([float(w) for w in self.weights]) + float(self.bias)
        return np.where(floats > 0, 1, -1).astype(np.int8)

    def relative_margin(self, norm: Norm = "sum") -> float:
        """Return 1 / (sum or largest of |weights| and |z|)."""
        sizes = [abs(w) for w in (*self.weights, self.bias)]
        return float(1 / (sum(sizes) if norm == "sum" else max(sizes)))


@dataclass(frozen=True)
class Certificate:
    """Proof that no threshold exists: a point that is a mean of black rows and of white rows.

    ``black`` and ``white`` hold (share, row number); the shares of each are positive and sum to 1. A plane with all
    black rows on one side would have that point on this side, and on the other (Farkas 1902).
    """

    black: tuple[tuple[Fraction, int], ...]
    white: tuple[tuple[Fraction, int], ...]

    def holds(self, rows: Signs, table: Signs) -> bool:
        """Check the certificate exactly, in rational arithmetic."""
        return (
            all(table[i] == 1 for _, i in self.black)
            and all(table[i] == -1 for _, i in self.white)
            and all(share > 0 for share, _ in (*self.black, *self.white))
            and sum(share for share, _ in self.black) == sum(share for share, _ in self.white) == 1
            and _mean(self.black, rows) == _mean(self.white, rows)
        )


def separate(rows: Signs, table: Signs, norm: Norm = "sum") -> Separator | Certificate:
    """Return the weights of largest margin relative to their norm, or a certificate that there are none.

    Minimises the norm of (w, z) under d_i (w . v_i + z) >= 1 (Haenggi and Moschytz, IEEE Trans. CAS-I 46 (1999) 304:
    margin / sum|weights| is the relative error that each entry may have). The solution is made rational and its margin
    computed and set to 1 exactly; a solution that is not right in rational arithmetic is never returned.

    Arguments: ``rows`` (n, d) of -1 and +1, ``table`` (n,) +1, -1, or 0 for rows that do not matter.
    """
    from scipy.optimize import linprog

    known, counts = _relevant(rows, table)
    points = np.column_stack([rows[known] * counts, np.ones(len(known))]).astype(float)
    signed = points * table[known, None]
    size = points.shape[1]
    if norm == "sum":  # w = w+ - w-
        cost, left = np.ones(2 * size), np.hstack([-signed, signed])
        right, bounds = -np.ones(len(known)), [(0, None)] * (2 * size)
    else:  # minimise t with |w| <= t; a small part of the sum keeps useless weights at zero
        cost = np.concatenate([np.full(2 * size, 1e-4), [1.0]])
        box = np.hstack([np.eye(size), np.eye(size), -np.ones((size, 1))])
        left = np.vstack([np.hstack([-signed, signed, np.zeros((len(known), 1))]), box])
        right, bounds = np.concatenate([-np.ones(len(known)), np.zeros(size)]), [(0, None)] * (2 * size + 1)
    found = linprog(cost, A_ub=left, b_ub=right, bounds=bounds, method="highs")
    if found.status == 0:
        exact = _exact_separator(found.x[:size] - found.x[size : 2 * size], rows[known] * counts, table[known])
        if exact is not None:
            return exact
    return certify(rows, table)


def certify(rows: Signs, table: Signs) -> Certificate:
    """Return the certificate that no threshold separates black rows from white ones; there has to be one.

    Raises:
        ArithmeticError: there is none, or it could not be made exact.
    """
    from scipy.optimize import linprog

    known, _ = _relevant(rows, table)
    black = table[known] > 0
    columns = np.column_stack([rows[known], np.ones(len(known))]).T * np.where(black, 1, -1)
    equations = np.vstack([columns, black.astype(float)])
    wanted = np.zeros(len(equations))
    wanted[-1] = 1.0
    found = linprog(np.zeros(len(known)), A_eq=equations, b_eq=wanted, bounds=(0, None), method="highs-ds")
    if found.status != 0:
        raise ArithmeticError("neither a threshold nor a certificate that there is none")
    support = np.flatnonzero(found.x > 1e-9)
    shares = _solve_exactly(equations[:, support], wanted)
    pairs = [(share, int(known[i])) for share, i in zip(shares, support, strict=True) if share]
    certificate = Certificate(
        tuple(pair for pair in pairs if table[pair[1]] > 0), tuple(pair for pair in pairs if table[pair[1]] < 0)
    )
    if not certificate.holds(rows, table):
        raise ArithmeticError("the certificate is not exact")
    return certificate


def _exact_separator(weights: Floats, rows: Signs, table: Signs) -> Separator | None:
    """Make weights rational, with denominators as small as keep the margin, and scale them to a margin of 1."""
    for denominator in (1, 2, 3, 4, 6, 12, 60, 1000, 10**6):
        near = [Fraction(float(w)).limit_denominator(denominator) for w in weights]
        if max(abs(float(f) - w) for f, w in zip(near, weights, strict=True)) > 1e-7 and denominator < 10**6:
            continue
        trial = Separator(tuple(near[:-1]), near[-1])
        margin = min(d * int(wanted) for d, wanted in zip(trial.drive(rows), table, strict=True))
        if margin > 0:
            return Separator(tuple(w / margin for w in trial.weights), trial.bias / margin)
    return None


def _solve_exactly(matrix: Floats, right: Floats) -> list[Fraction]:
    """Solve an overdetermined system of small whole numbers with independent columns by elimination of fractions."""
    table = [[Fraction(int(v)) for v in (*row, r)] for row, r in zip(matrix, right, strict=True)]
    size = matrix.shape[1]
    for column in range(size):
        pivot = next((i for i in range(column, len(table)) if table[i][column]), None)
        if pivot is None:
            raise ArithmeticError("the solution is not a vertex")
        table[column], table[pivot] = table[pivot], table[column]
        table[column] = [v / table[column][column] for v in table[column]]
        for i, row in enumerate(table):
            if i != column and row[column]:
                table[i] = [a - row[column] * b for a, b in zip(row, table[column], strict=True)]
    return [table[i][-1] for i in range(size)]


def _relevant(rows: Signs, table: Signs) -> tuple[Integers, Flags]:
    """Return the numbers of rows that suffice, and which variables change an answer.

    Of variables that change nothing, only rows with -1 are needed. That applies to whole tables, whose row numbers are
    the rows' bits; of any other all rows that matter are returned.
    """
    size, index = rows.shape[1], np.arange(len(rows))
    counts = np.ones(size, dtype=bool)
    kept = table != 0
    if len(rows) == 1 << size and np.array_equal(window_numbers(rows), index):
        for variable in range(size):
            bit = 1 << (size - 1 - variable)
            if np.array_equal(table, table[index & ~bit]):
                counts[variable] = False
                kept &= (index & bit) == 0
    return np.flatnonzero(kept), counts


def _mean(parts: Sequence[tuple[Fraction, int]], rows: Signs) -> list[Any]:
    return [sum((share * int(rows[i, j]) for share, i in parts), Fraction(0)) for j in range(rows.shape[1])]


def soft_margin_colours(rows: Signs, table: Signs, weights: Floats, hard: int = 0) -> Signs | None:
    """Return the colours (n,) of a linear threshold that fits a table with the least weighted sum of slacks.

    minimise sum c_i e_i under d_i (w . v_i + z) >= 1 - e_i, e_i >= 0 (Cortes and Vapnik, "Support-vector networks",
    Machine Learning 20 (1995) 273, without the norm); rows of the colour ``hard`` must have e_i = 0. None if there is
    no solution, or if |w . v_i + z| is below 1e-6 for a row.
    """
    from scipy.optimize import linprog
    from scipy.sparse import csr_array, diags_array, hstack

    known = np.flatnonzero(table)
    size = rows.shape[1] + 1
    signed = np.column_stack([rows[known], np.ones(len(known))]) * table[known, None].astype(float)
    free = np.where(table[known] == hard, 0.0, 1.0)
    left = hstack([csr_array(-signed), diags_array(-free)])
    cost = np.concatenate([np.zeros(size), weights[known] * free])
    bounds = [(-100.0, 100.0)] * size + [(0.0, None)] * len(known)
    found = linprog(cost, A_ub=left, b_ub=-np.ones(len(known)), bounds=bounds, method="highs")
    if found.status != 0:
        return None
    drive = rows @ found.x[: size - 1] + found.x[size - 1]
    if np.abs(drive).min() < 1e-6:
        return None
    return np.where(drive > 0, 1, -1).astype(np.int8)
