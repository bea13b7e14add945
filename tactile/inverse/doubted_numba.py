"""Whether one load that leaves much unexplained is the answer all the same, compiled: noise alone leaves as much.

What `tactile.inverse.alternatives` and `tactile.inverse.steadiness` ask of more than a few taxels, in their order.
"""

import math

import numpy as np

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.alternatives import ALONE, FEW, NO_LESS, PATCH, SHARE, WORST
from tactile.inverse.consensus_numba import signals
from tactile.inverse.least_squares.components_numba import components
from tactile.inverse.least_squares.fit_numba import fit, near
from tactile.inverse.steadiness import DIFFERS, LEANT_ON, MOVES
from tactile.inverse.windows import COARSE, LARGE, LEAST, NOISE


@kept_njit(error_model="numpy")
def may_be_another(remains, at, rows, cols, depth, chi, free):  # type: ignore[no-untyped-def]  # numba types it
    """Whether a load leaves as much (n, 3) at a taxel of a large pad as another's makes: `windows.may_be_many`."""
    if min(rows, cols) <= LARGE:
        return False
    pitch = max(abs(at[cols, 0] - at[0, 0]), abs(at[cols, 1] - at[0, 1]))
    if pitch > COARSE * depth:
        return False
    most = 0.0
    for i in range(len(remains)):
        for m in range(3):
            most = max(most, abs(remains[i, m]))
    return most >= LEAST / 2 and not most < NOISE * math.sqrt(chi / max(free, 1))


@kept_njit(error_model="numpy")
def holds(  # type: ignore[no-untyped-def]
    seen, felt, scale, tie, loads, chi, misfit, remains, tried, first, at, planes, weights, order, depth, strain, layer,
    top, steps, reach, most, enough, known,
):  # fmt: skip
    """Whether no taxel is to blame for what is left, no place explains more, and the load's own is steady.

    ``seen``, ``felt``, ``scale`` and ``tie`` as `consensus_numba.signals` has them for the place ``first`` of those
    that were ``tried``; ``remains`` (n, 3) of them; ``reach``, ``most`` and ``enough`` as `fit_numba.near` has them;
    ``known``: whether the noise is.
    """
    n, worst = len(seen), 0.0
    for i in range(n):
        worst = max(worst, remains[i, 0] ** 2 + remains[i, 1] ** 2 + remains[i, 2] ** 2)
    share = SHARE if known else max(SHARE, WORST / (3 * n - 5))
    if n <= ALONE or worst > share * chi or misfit > PATCH:
        return False
    load = np.empty((1, 5))
    if n <= FEW:
        for k in range(len(tried)):
            if k == first or not tried[k, 2] < np.inf or _tried_before(tried, k):
                continue
            places, there, scaled, held = signals(at, planes, weights, order, tried[k], depth, strain, top)
            load[0, 0], load[0, 1] = tried[k, 0], tried[k, 1]
            components(places, there, scaled, load[0], strain, layer, held)
            left, _, _ = fit(places, there, scaled, load, strain, layer, held, steps)
            if (chi - left) * (3 * n - 5) > NO_LESS * chi:
                return False
    part, weight = felt.copy(), scale.copy()
    for i in range(n):
        part[i, 2] = weight[i, 2] = 0.0
    asked, part, weight = near(seen, part, weight, loads, reach, most, enough)
    if _moved(asked, part, weight, loads, load, strain, layer, tie, steps) > DIFFERS:
        return False
    if n > FEW:
        return True
    rows = np.empty((n - 1, 2)), np.empty((n - 1, 3)), np.empty((n - 1, 3))
    for k in range(min(n, LEANT_ON)):
        for i in range(n - 1):
            j = i if i < k else i + 1
            rows[0][i, 0], rows[0][i, 1] = seen[j, 0], seen[j, 1]
            for m in range(3):
                rows[1][i, m], rows[2][i, m] = felt[j, m], scale[j, m]
        if _moved(rows[0], rows[1], rows[2], loads, load, strain, layer, tie, steps) > MOVES:
            return False
    return True


@kept_helper(error_model="numpy")
def _tried_before(tried, k):  # type: ignore[no-untyped-def]
    """Whether an earlier place is the same."""
    for j in range(k):  # noqa: SIM110 - numba has no generators
        if tried[j, 0] == tried[k, 0] and tried[j, 1] == tried[k, 1]:
            return True
    return False


@kept_helper(error_model="numpy")
def _moved(seen, felt, scale, loads, load, strain, layer, tie, steps):  # type: ignore[no-untyped-def]
    """Return how far [depths] the load lies from that of a fit to these signals from it on."""
    for m in range(5):
        load[0, m] = loads[0, m]
    fit(seen, felt, scale, load, strain, layer, tie, steps)
    dx, dy = load[0, 0] - loads[0, 0], load[0, 1] - loads[0, 1]
    return math.sqrt(dx * dx + dy * dy)
