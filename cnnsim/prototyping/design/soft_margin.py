"""Soft margin: a threshold for as many windows as possible, where none is right on all."""

import numpy as np

from cnnsim.prototyping.design.rule import Signs
from cnnsim.support import Floats


def soft_margin_colours(rows: Signs, table: Signs, weights: Floats, hard: int = 0) -> Signs | None:
    """Return the colours (n,) that a threshold gives which misses a table by little: least sum of weighted shortfalls.

    minimise sum c_i e_i under d_i (w . v_i + z) >= 1 - e_i, e_i >= 0 (Cortes and Vapnik, "Support-vector networks",
    Machine Learning 20 (1995) 273, without the norm); rows of the colour ``hard`` must have e_i = 0. None if a sum
    comes out too near to zero to have a colour.
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
