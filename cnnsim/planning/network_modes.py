"""Stability of a network of terms: its modes, linearised with the smallest and the largest slopes of its functions."""

from collections.abc import Iterator
from functools import lru_cache
from itertools import product

import numpy as np

from cnnsim.network import Characteristic, LayeredTemplate, Template, Term, fixed
from cnnsim.network.term import Range
from cnnsim.planning.scheme import Scheme
from cnnsim.planning.stability import Modes, coupling, decaying, limit_of
from cnnsim.planning.step import Duration
from cnnsim.support import Floats

Shape = tuple[int, int]

_SHAPES = ((1, 1), (1, 2), (2, 1), (1, 10), (10, 1), (3, 3), (6, 6))
_MOST_CELLS = 120


def step_bound(network: LayeredTemplate, output: Characteristic, duration: Duration, scheme: Scheme) -> float:
    """Return a step below which no decaying mode can grow: Gershgorin's circles, with the tables' largest slopes.

    In a row of the Jacobian the centre is at least d and the rest sums up to at most R, so no decay is faster than
    1 - min(0, d - R), over the layer's time constant. This is sufficient, not necessary. Modes that oscillate while
    they decay are computed (`network_modes`). Jumps are not included: there Euler's state swings by about step x jump.
    """
    fastest = max(
        _decay(layer, output) / time for layer, time in zip(network.layers, network.time_constants, strict=True)
    )
    real = limit_of(np.array([-fastest + 0j]), duration, scheme)
    return min(real, limit_of(decaying(network_modes(network, output)), duration, scheme))


@lru_cache(maxsize=64)
def network_modes(network: LayeredTemplate, output: Characteristic) -> Modes:
    """Return the modes on small grids with all cells in one piece.

    With space-variant weights these are parts of the network's grid, the whole grid if it is small. Delayed terms and
    products of two arguments are omitted: they are not linear in the present state.
    """
    layers, varying = len(network.layers), _grid_of_weights(network)
    most = _MOST_CELLS // layers
    shapes = [shape for shape in _SHAPES if shape[0] * shape[1] <= most] or [(1, 1)]
    parts = [(shape, (0, 0)) for shape in shapes]
    if varying is not None and varying[0] * varying[1] <= most:
        parts = [(varying, (0, 0))]
    elif varying is not None:  # first, middle and last cells
        inside = [shape for shape in shapes if shape[0] <= varying[0] and shape[1] <= varying[1]]
        places = product(inside, (0.0, 0.5, 1.0), (0.0, 0.5, 1.0))
        parts = [(s, (int(p * (varying[0] - s[0])), int(q * (varying[1] - s[1])))) for s, p, q in places]
    found = [np.linalg.eigvals(_jacobian(network, output, *part, side)) for part in parts for side in (0, 1)]
    return np.concatenate(found).astype(complex)


def _grid_of_weights(network: LayeredTemplate) -> tuple[int, int] | None:
    """Return the grid of space-variant weights, None if there are none."""
    weights = [term.weights for layer in network.layers for term in layer.feedback_terms if term.weights.ndim == 4]
    return (weights[0].shape[2], weights[0].shape[3]) if weights else None


def _jacobian(network: LayeredTemplate, output: Characteristic, shape: Shape, at: Shape, side: int) -> Floats:
    cells, layers = shape[0] * shape[1], len(network.layers)
    total = np.zeros((layers, layers, cells, cells))
    for number, layer in enumerate(network.layers):
        total[number, number] += output.slopes[1] * coupling(layer.A, shape, fixed(0)) - np.eye(cells)
        for term in layer.feedback_terms:
            if term.times is None and not term.delay:
                rise = term.slopes[side]
                for quantity, other, matrix in _parts(term, number, shape, at):
                    if quantity != "u":
                        total[number, other] += rise * (output.slopes[1] if quantity == "y" else 1.0) * matrix
        total[number] /= network.time_constants[number]
    return total.transpose(0, 2, 1, 3).reshape(layers * cells, layers * cells)


def _parts(term: Term, own: int, shape: Shape, at: Shape) -> Iterator[tuple[str, int, Floats]]:
    """Yield (quantity, layer, matrix) of the values that a term reads: neighbours, and the centre of a difference."""
    if term.weights.ndim == 2:
        matrix, total = coupling(term.weights, shape, fixed(0)), float(term.weights.sum()) * np.ones(shape)
    else:
        weights = term.weights[:, :, at[0] : at[0] + shape[0], at[1] : at[1] + shape[1]]
        matrix, total = _coupling(weights), weights.sum(axis=(0, 1))
    yield term.of.neighbour, own if term.layer is None else term.layer, matrix
    if term.of.centre is not None:
        yield term.of.centre, own, -np.diag(total.ravel())


def _coupling(weights: Floats) -> Floats:
    """Return the matrix (cells, cells) of space-variant weights (side, side, rows, cols); virtual cells are omitted."""
    side, _, rows, cols = weights.shape
    matrix = np.zeros((rows, cols, rows + side - 1, cols + side - 1))
    here = np.indices((rows, cols))
    for k, l in np.ndindex(side, side):
        matrix[(*here, here[0] + k, here[1] + l)] = weights[k, l]
    r = side // 2
    return matrix[:, :, r : r + rows, r : r + cols].reshape(rows * cols, rows * cols)


def _decay(layer: Template, output: Characteristic) -> float:
    low, high = output.slopes
    diagonal = min(_products((layer.self_feedback,) * 2, (low, high)))
    off = high * sum(abs(tap.weight) for tap in layer.feedback_taps if (tap.k, tap.l) != (0, 0))
    for term in layer.feedback_terms:
        rises = term.slopes
        for argument in {term.of, *((term.times,) if term.times else ())}:
            for k, l, weight in term.taps:
                weights = float(np.min(weight)), float(np.max(weight))
                own = k == l == 0 and term.layer is None and not term.delay
                for quantity, sign, here in ((argument.neighbour, 1, own), (argument.centre, -1, not term.delay)):
                    if quantity in ("x", "y"):
                        slope = _products(_products(weights, rises), (low, high) if quantity == "y" else (1.0, 1.0))
                        if here:
                            diagonal += min(sign * side for side in slope)
                        else:
                            off += max(map(abs, slope))
    return 1.0 - min(0.0, diagonal - off)


def _products(a: Range, b: Range) -> Range:
    """Return the smallest and the largest product of two ranges."""
    found = [p * q for p, q in product(a, b)]
    return min(found), max(found)
