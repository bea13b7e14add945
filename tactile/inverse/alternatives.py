"""Alternatives to one load that all taxels feel: a clipped reading, a taxel that contradicts, several loads."""

from dataclasses import replace

import numpy as np

from cnnsim.support import Floats
from tactile.inverse.attempt import DOUBT, Attempt, Taxels
from tactile.inverse.least_squares.fit import SURELY, Fit, fitted
from tactile.inverse.several import APART, EXPLAINED, several, simplest

POINT = 0.25
"""Loads that leave a larger share of the signals unexplained are not points: a tip of half a depth leaves 0.1."""
FEW = 16
"""With so few taxels every place is tried in doubt."""
PATCH = 0.1
"""What leaves so much may be several loads."""
SHARE = 0.25
"""A taxel that contradicts all others has so much of what is left, unless that is very much."""
SLIGHT = 2e-3
"""From this share on a clipped reading may be to blame: it has moved a place by a tenth of a depth."""
CLIPPED = 20.0
"""How many times less of a variance is left without readings that are clipped."""
HINT = 3.0
"""To first order it is at least so many times less."""
LEAST_FREE = 6
"""So few degrees of freedom let chance explain all the rest."""
NEAR_END = 1e-3
"""Readings that are so near to the largest one may be cut off at the same end."""
FRICTION = 2.0
"""A load with more times its normal force in shear than skin holds is none, but a taxel that reads falsely."""
RIVALS = 4.0
"""Two explanations of which neither leaves so many times less of a variance than the other are both possible."""


def explained(taxels: Taxels, one: Attempt) -> Attempt:
    """Return the attempt, or what explains the signals much better in its place; ambiguous where two do alike."""
    if one.fit.misfit > SLIGHT:
        one = _clipped(one) or one
    if one.fit.misfit <= DOUBT and one.fit.foreign is None:
        return one
    if one.fit.misfit > POINT or one.order.size <= FEW:
        one = taxels.attempt(one.order, thorough=True)
        one = _clipped(one) or one
    if (one.fit.misfit <= DOUBT or not _alone(one)) and one.fit.foreign is None:
        return one
    suspects = {0, *one.fit.contrary[:3].tolist()} if one.order.size > 4 else set(range(4))
    if one.fit.foreign is not None:
        suspects.add(one.fit.foreign)
    tried = [taxels.attempt(np.delete(one.order, k)) for k in sorted(suspects)]
    best = min((_clipped(other) or other for other in tried), key=lambda other: other.left)
    ways = [one]
    if best.fit.misfit < POINT and simplest([one, best], POINT) is best:
        ways.append(best)
    if ways[-1].fit.misfit > (PATCH if len(ways) == 1 and one.fit.foreign is None else EXPLAINED):
        ways += several(taxels, one, POINT)
    found = simplest(ways, POINT)
    found = _clipped(found) or found
    return _or_a_load(taxels, one, found) if found.order.size < one.order.size else _or_a_taxel(found)


def _alone(one: Attempt) -> bool:
    """Whether one taxel may be to blame for what is left: it has much of it, or so few taxels hide it."""
    if one.order.size <= 8:
        return True
    worst = one.fit.rest[one.fit.contrary[0]]
    return bool((worst @ worst) > SHARE * one.fit.chi) or one.fit.misfit > PATCH


def _clipped(one: Attempt) -> Attempt | None:
    """Return the attempt without the largest readings, if they are cut off: larger ones explain all the others."""
    from tactile.inverse.least_squares.doubt_numba import without_largest  # numba is slow to import

    signals, loads = one.fit.signals, one.fit.loads
    if one.clipped or one.fit.free <= LEAST_FREE:
        return None
    if len(loads) == 1:
        parts = signals.seen, signals.felt, signals.scale, loads[0], signals.strain, signals.layer, signals.tie
        chi, beyond, count = without_largest(*parts, NEAR_END)
        if count == 1 and (chi * HINT > one.fit.chi or beyond < 1):
            return None
    raw = np.abs(signals.felt / signals.scale)
    cut = raw >= raw.max() * (1 - NEAR_END)
    if cut.all(axis=1).any():
        return None
    without = signals._replace(
        felt=np.where(cut, 0.0, signals.felt), scale=np.where(cut, 0.0, signals.scale), lost=int(cut.sum())
    )
    fit = fitted(without, one.fit.loads)
    found = replace(one, fit=fit, clipped=tuple(signals.cells[cut.any(axis=1)].tolist()))
    if not found.left * CLIPPED < one.left:
        return None
    return found if (fit.made(signals)[cut] / signals.felt[cut] > 1).all() else None


def _or_a_load(taxels: Taxels, one: Attempt, found: Attempt) -> Attempt:
    """Return what was found without a taxel, or that taxel explained as another load; ambiguous if both do alike."""
    gone = np.setdiff1d(one.order, found.order)
    if gone.size != 1:
        return found
    known, rival, taxel = _seen_from(taxels, one, found), None, int(gone[0])
    for dx, dy, force, _ in taxels.planes[:, :, taxel].tolist():
        if not np.isfinite([dx, dy, force]).all():
            continue
        place = (taxels.at[taxel] + (dx, dy)) / taxels.depth - _origin(taxels, one)
        fit = fitted(one.fit.signals, np.concatenate([known, [[*place, 0.0, 0.0, force / one.top]]]))
        other = replace(one, fit=fit, ambiguous=False)
        if _presses(fit) and (rival is None or other.left < rival.left):
            rival = other
    return found if rival is None else _surer(found, rival)


def _or_a_taxel(found: Attempt) -> Attempt:
    """Return the loads that were found, or one less and a taxel that reads falsely; ambiguous if both do alike."""
    rival, signals, loads = None, found.fit.signals, found.fit.loads
    for k in range(len(loads)) if len(loads) > 1 else ():
        near = int(((signals.seen - loads[k, :2]) ** 2).sum(axis=1).argmin())
        fit = fitted(signals.without(near), np.delete(loads, k, axis=0))
        other = replace(found, order=fit.signals.cells, fit=fit)
        rival = other if rival is None or other.left < rival.left else rival
    return found if rival is None else _surer(found, rival)


def _surer(found: Attempt, rival: Attempt) -> Attempt:
    """Return the one that leaves much less than the other, or what was found as one of two that are both possible."""
    if rival.left * RIVALS < found.left:
        return rival
    more = rival.fit.chi * rival.top**2 - found.fit.chi * found.top**2
    sure = found.left * RIVALS < rival.left or more > SURELY**2 * found.fit.variance * found.top**2
    return found if sure else replace(found, ambiguous=True)


def _presses(fit: Fit) -> bool:
    """Whether the last load is one that skin can hold, apart from the others."""
    q, r, f = fit.loads[-1, 2:].tolist()
    gaps = np.hypot(*(fit.loads[:-1, :2] - fit.loads[-1, :2]).T)
    return bool(f > 0 and np.hypot(q, r) < FRICTION * f and gaps.min() >= APART and np.isfinite(fit.spread).all())


def _seen_from(taxels: Taxels, one: Attempt, found: Attempt) -> Floats:
    """Return the loads of an attempt as another one sees and scales them."""
    loads = found.fit.loads * [1, 1, *[found.top / one.top] * 3]
    loads[:, :2] += _origin(taxels, found) - _origin(taxels, one)
    return loads


def _origin(taxels: Taxels, one: Attempt) -> Floats:
    return np.asarray(taxels.at[one.order[0]] / taxels.depth - one.fit.signals.seen[0])
