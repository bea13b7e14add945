"""One load from the taxels of one frame at one go, compiled: their consensus, then least squares, and what is foreign.

What `tactile.inverse.attempt` does of it in steps for large pads: each call from Python costs as much as four taxels.
"""

import numpy as np

from cnnsim.support.compiled_loops import kept_njit
from tactile.inverse.consensus_numba import consensus, signals
from tactile.inverse.least_squares.components_numba import components
from tactile.inverse.least_squares.doubt_numba import foreign
from tactile.inverse.least_squares.equations_numba import energy, rest
from tactile.inverse.least_squares.fit_numba import fit, near
from tactile.inverse.least_squares.start_numba import layer_place


@kept_njit(error_model="numpy")
def one_load(  # type: ignore[no-untyped-def]  # numba types it at the call
    at, planes, signal, trust, scale, order, depth, strain, layer, top, noise, voters, seeds, steps, reach, least,
    times, most, enough,
):  # fmt: skip
    """Return the places tried, best and next best, the signals as `signals` has them, and the fit from the best on.

    The last is (loads, chi, whole, spread), what it leaves unexplained, and the taxel that feels most of what the load
    does not make. Of more than ``most`` taxels those near the load are fitted, if they are ``enough``.
    """
    tried, first, second = consensus(at, planes, signal, trust, order[:voters], depth, seeds)
    seen, felt, scaled, tie = signals(at, planes, scale, order, tried[first], depth, strain, top)
    loads = np.zeros((1, 5))
    if len(layer) > 0:
        tried, first, second = layer_place(
            seen[:voters], felt[:voters], scaled[:voters], tried, strain, layer, tie, noise, steps
        )
    loads[0, 0], loads[0, 1] = tried[first, 0], tried[first, 1]
    asked, part, weight = near(seen, felt, scaled, loads, reach, most, enough)
    components(asked, part, weight, loads[0], strain, layer, tie)
    chi, whole, spread = fit(asked, part, weight, loads, strain, layer, tie, steps)
    if len(asked) < len(seen):
        chi, whole = energy(rest(seen, felt, scaled, loads, strain, layer)), energy(felt)
    stranger = -1
    for i in range(len(seen)):
        if (seen[i, 0] - loads[0, 0]) ** 2 + (seen[i, 1] - loads[0, 1]) ** 2 > reach * reach:
            left = rest(seen, felt, scaled, loads, strain, layer)
            stranger = foreign(seen, left, felt, loads, reach, least, times)
            break
    return tried, first, second, seen, felt, scaled, tie, loads, chi, whole, spread, stranger
