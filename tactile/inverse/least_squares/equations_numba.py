"""Normal equations of point loads from the signals of all taxels, compiled, on the half-space or on a layer.

The layer's are taken where its table, that of `layer_field`, is not empty. Signals come over their standard deviations,
and ``scale`` (n, 3) is what they were multiplied by.
"""

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.least_squares.half_space_numba import LOOSELY, half_space_rest, half_space_slopes, half_space_sums
from tactile.inverse.least_squares.layer_numba import layer_rest, layer_slopes, layer_sums


@kept_njit(error_model="numpy")
def slopes(at, scale, load, strain, layer, rest, out):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Take a load's signals from ``rest`` (3, n) and fill ``out`` (5, 3, n): their slopes along its five numbers."""
    if len(layer) > 0:
        layer_slopes(at, scale, load, layer, rest, out)
    else:
        half_space_slopes(at, scale, load, strain, rest, out)


@kept_helper(error_model="numpy", fastmath=LOOSELY)
def product(one, other):  # type: ignore[no-untyped-def]
    """Return the sum of the products of two rows of numbers."""
    total = 0.0
    for i in range(len(one)):
        total += one[i] * other[i]
    return total


@kept_njit(error_model="numpy")
def equations(at, felt, scale, loads, strain, layer, matrix, vector):  # type: ignore[no-untyped-def]
    """Fill the normal equations at these loads, of the matrix its lower triangle, and return chi^2."""
    if len(loads) > 1:
        return _equations_of_several(at, felt, scale, loads, strain, layer, matrix, vector)
    if len(layer) > 0:
        chi, products, drawn = layer_sums(at, felt, scale, loads[0], layer)
    else:
        chi, products, drawn = half_space_sums(at, felt, scale, loads[0], strain)
    for m in range(5):
        vector[m] = drawn[m]
        for n in range(m + 1):
            matrix[m, n] = products[m * (m + 1) // 2 + n]
    return chi


@kept_helper(error_model="numpy")
def _equations_of_several(at, felt, scale, loads, strain, layer, matrix, vector):  # type: ignore[no-untyped-def]
    out, left = np.empty((5 * len(loads), 3, len(at))), felt.T.copy()
    for k in range(len(loads)):
        slopes(at, scale, loads[k], strain, layer, left, out[5 * k : 5 * k + 5])
    table, signals = out.reshape((5 * len(loads), felt.size)), left.reshape(felt.size)
    for m in range(len(table)):
        vector[m] = product(table[m], signals)
        for n in range(m + 1):
            matrix[m, n] = product(table[m], table[n])
    return product(signals, signals)


@kept_njit(error_model="numpy")
def rest(at, felt, scale, loads, strain, layer):  # type: ignore[no-untyped-def]
    """Return the signals (n, 3) that the loads do not explain."""
    if len(layer) > 0:
        return layer_rest(at, felt, scale, loads, layer)
    return half_space_rest(at, felt, scale, loads, strain)


@kept_njit(error_model="numpy")
def energy(signals):  # type: ignore[no-untyped-def]
    """Return the sum of the squares of signals (n, 3)."""
    total = 0.0
    for i in range(len(signals)):
        total += signals[i, 0] ** 2 + signals[i, 1] ** 2 + signals[i, 2] ** 2
    return total
