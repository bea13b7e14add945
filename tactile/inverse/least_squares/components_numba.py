"""Components of a point load at a given place from the signals of several taxels, compiled: where a fit starts."""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.least_squares.fit_numba import solve
from tactile.inverse.least_squares.layer_numba import layer_forces


@kept_njit(error_model="numpy")
def components(seen, felt, scale, load, strain, layer, tie):  # type: ignore[no-untyped-def]
    """Fill in (Q, R, F) of a load by least squares from the part of each signal that a load at its place explains.

    For three taxels that is eq. (14); by Householder's reflections, shear held at zero where ``tie`` says so.
    """
    if len(layer) > 0:
        layer_components(seen, felt, scale, load, layer, tie)
        return
    taxels = len(seen)
    table = np.zeros((taxels + 2, 4))
    for i in range(taxels):
        x, y = seen[i, 0] - load[0], seen[i, 1] - load[1]
        t = x * x + y * y
        near = 1 / (1 + t)
        g = near * near * math.sqrt(near)
        lean, height = (3.0, t - 2) if strain else (1.0, -1.0)
        a, b, c = -lean * x * g * scale[i, 0], -lean * y * g * scale[i, 1], height * g * scale[i, 2]
        size = math.sqrt(a * a + b * b + c * c)
        table[i, 0], table[i, 1], table[i, 2] = x * size, y * size, size
        table[i, 3] = (felt[i, 0] * a + felt[i, 1] * b + felt[i, 2] * c) / size
    table[taxels, 0] = math.sqrt(tie[0])
    if tie[0] > 0:
        table[taxels, 1] = tie[1] / table[taxels, 0]
        table[taxels + 1, 1] = math.sqrt(max(tie[2] - tie[1] * tie[1] / tie[0], 0.0))
    else:
        table[taxels + 1, 1] = math.sqrt(tie[2])
    for k in range(3):
        norm = 0.0
        for i in range(k, len(table)):
            norm += table[i, k] * table[i, k]
        norm = math.sqrt(norm)
        if table[k, k] > 0:
            norm = -norm
        head = table[k, k] - norm
        for j in range(k + 1, 4):
            along = head * table[k, j]
            for i in range(k + 1, len(table)):
                along += table[i, k] * table[i, j]
            along /= norm * head
            table[k, j] += along * head
            for i in range(k + 1, len(table)):
                table[i, j] += along * table[i, k]
        table[k, k] = norm
    load[4] = table[2, 3] / table[2, 2]
    load[3] = (table[1, 3] - table[1, 2] * load[4]) / table[1, 1]
    load[2] = (table[0, 3] - table[0, 2] * load[4] - table[0, 1] * load[3]) / table[0, 0]


@kept_helper(error_model="numpy")
def layer_components(seen, felt, scale, load, layer, tie):  # type: ignore[no-untyped-def]
    """Fill in (Q, R, F) of a load on a layer by least squares and return the chi^2 that is left."""
    matrix, vector, factor, answer = np.empty((3, 3)), np.empty(3), np.empty((3, 3)), np.empty(3)
    whole = layer_forces(seen, felt, scale, load, layer, matrix, vector)
    matrix[0, 0] += tie[0]
    matrix[1, 0] += tie[1]
    matrix[1, 1] += tie[2]
    if not solve(matrix, vector, 0.0, factor, answer):
        return np.inf
    for m in range(3):
        load[2 + m] = answer[m]
        whole -= answer[m] * vector[m]
    return max(whole, 0.0)
