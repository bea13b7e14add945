"""Decaying modes of a network of terms, linearised where its functions are flattest and where they are steepest."""

from collections.abc import Iterator
from functools import lru_cache
from itertools import product

import numpy as np

from cnnsim.network.boundary import fixed
from cnnsim.network.characteristic import Characteristic
from cnnsim.network.layers import LayeredTemplate
from cnnsim.network.term import Term
from cnnsim.planning.stability import Modes, coupling, decaying
from cnnsim.support.types import Floats

Range = tuple[float, float]

_SHAPES = ((1, 1), (1, 2), (2, 1), (1, 10), (10, 1), (3, 3), (6, 6))
_MOST_CELLS = 120


@lru_cache(maxsize=64)
def network_modes(network: LayeredTemplate, output: Characteristic) -> Modes:
    """Return the modes that decay, one of each complex pair, on small grids with all cells in one piece.

    Delayed terms and products of two arguments are left out: they are not linear in the state of now.
    """
    layers = len(network.layers)
    shapes = [shape for shape in _SHAPES if layers * shape[0] * shape[1] <= _MOST_CELLS] or [(1, 1)]
    found = [np.linalg.eigvals(_jacobian(network, output, shape, side)) for shape in shapes for side in (0, 1)]
    return decaying(np.concatenate(found))


def _jacobian(network: LayeredTemplate, output: Characteristic, shape: tuple[int, int], side: int) -> Floats:
    cells, layers = shape[0] * shape[1], len(network.layers)
    total = np.zeros((layers, layers, cells, cells))
    for number, layer in enumerate(network.layers):
        total[number, number] += output.steepest * coupling(layer.A, shape, fixed(0)) - np.eye(cells)
        for term in layer.feedback_terms:
            if term.times is None and not term.delay and term.weights.ndim == 2:
                rise = slopes_of(term)[side]
                for quantity, other, matrix in _parts(term, number, shape):
                    if quantity != "u":
                        total[number, other] += rise * (output.steepest if quantity == "y" else 1.0) * matrix
        total[number] /= network.time_constants[number]
    return total.transpose(0, 2, 1, 3).reshape(layers * cells, layers * cells)


def _parts(term: Term, own: int, shape: tuple[int, int]) -> Iterator[tuple[str, int, Floats]]:
    """Yield what is read, of which layer, with which weights: the neighbours, and less the centre of a difference."""
    matrix = coupling(term.weights, shape, fixed(0))
    yield term.of.neighbour, own if term.layer is None else term.layer, matrix
    if term.of.centre is not None:
        yield term.of.centre, own, -float(term.weights.sum()) * np.eye(len(matrix))


def slopes_of(term: Term) -> Range:
    """The smallest and the largest slope of f(v) m in v and m."""
    if term.table is None:
        return (1.0, 1.0) if term.times is None else (-4.0, 4.0)
    if term.times is None:
        return term.table.slopes
    if term.times == term.of:
        return term.table.product_slopes
    most = term.table.bound + 2 * max(map(abs, term.table.slopes))
    return -most, most


def products(a: Range, b: Range) -> Range:
    """The smallest and the largest product of two ranges."""
    every = [p * q for p, q in product(a, b)]
    return min(every), max(every)
