"""Alternatives to one load that all taxels feel: a clipped reading, a taxel that contradicts, several loads."""

from dataclasses import replace

import numpy as np

from cnnsim.support import Floats
from tactile.inverse.attempt import DOUBT, Attempt, Taxels
from tactile.inverse.clipped import at_one_end, clipped
from tactile.inverse.false_reading import dead, without_a_reading
from tactile.inverse.least_squares.fit import SLIGHT, SURELY, Fit, fitted
from tactile.inverse.several import APART, EXPLAINED, as_ranked, several, simplest
from tactile.inverse.wide_tip import left_by_a_tip, may_be_a_tip

POINT = 0.25
"""Loads that leave a larger share of the signals unexplained are not points: a tip of half a depth leaves 0.1."""
FEW = 16
"""With so few taxels every place is tried in doubt, ..."""
NO_LESS = 0.1
"""... and counts if it leaves so much of a variance less: fits that end at one place differ by a hundredth."""
PATCH = 0.1
"""What leaves so much may be several loads."""
ALONE = 8
"""Of so few taxels any may be to blame for what is left, ..."""
SHARE = 0.25
"""... of more one that contradicts all others: it has so much of what is left, unless that is very much."""
WORST = 13.5
"""Variances that noise alone leaves at the worst of 9 to 25 taxels in one frame of 20: one that has no more of what is
left, where nobody knows the noise, contradicts nothing."""
FRICTION = 2.0
"""A load with more times its normal force in shear than skin holds is none, but a taxel that reads falsely."""
TWO = 6
"""Taxels at least from which two loads are told where the noise is known."""
BESIDE, HINTED, EVIDENT = 1.2, 0.5, 30.0
"""A second load is looked for so many depths from the first, if one explains so much of what is left to first order;
it is told where noise is left, or so many times less of a variance."""
RIVALS = 4.0
"""Two explanations of which neither leaves so many times less of a variance than the other are both possible."""


def explained(taxels: Taxels, one: Attempt) -> Attempt:
    """Return the attempt, or what explains the signals much better in its place; ambiguous where two do alike."""
    first, one = one, _sure(one)
    if one.fit.excess > 0 or one.fit.misfit > SLIGHT:
        one = _mended(one)
        if (two := _second(one)) is not None:
            return _or_a_taxel(two)
    if one.fit.misfit <= DOUBT and one.fit.foreign is None:
        return one
    if one.fit.misfit > POINT or one.order.size <= FEW:
        again = taxels.attempt(one.order, thorough=True)
        less = (first.fit.chi - again.fit.chi) * first.fit.free > NO_LESS * first.fit.chi
        one = _mended(_sure(again)) if less else one
    if (one.fit.misfit <= DOUBT or not _alone(one)) and one.fit.foreign is None:
        return one
    suspects = {0, *one.fit.contrary[:3].tolist()} if one.order.size > 4 else set(range(4))
    if one.fit.foreign is not None:
        suspects.add(one.fit.foreign)
    tried = [taxels.attempt(np.delete(one.order, k)) for k in sorted(suspects)]
    best = min((clipped(other) or other for other in tried), key=lambda other: other.left)
    ways = [one]
    if best.fit.misfit < POINT and simplest([one, best], POINT) is best:
        ways.append(best)
    if ways[-1].fit.misfit > (PATCH if len(ways) == 1 and one.fit.foreign is None else EXPLAINED):
        ways += several(taxels, one, POINT)
    found = simplest(ways, POINT)
    found = clipped(found) or found
    if found.order.size < one.order.size:
        return _or_a_tip(one, _or_a_load(taxels, one, found))
    return _or_a_taxel(found)


def _alone(one: Attempt) -> bool:
    """Whether one taxel may be to blame for what is left: it has much of it, or so few taxels hide it."""
    if one.order.size <= ALONE:
        return True
    fit = one.fit
    worst, share = fit.rest[fit.contrary[0]], SHARE if fit.signals.noise is not None else max(SHARE, WORST / fit.free)
    return bool((worst @ worst) > share * fit.chi) or fit.misfit > PATCH


def _sure(one: Attempt) -> Attempt:
    """Return the attempt without the readings that surely are false, whatever they leave."""
    return dead(one) or at_one_end(one) or one


def _mended(one: Attempt) -> Attempt:
    """Return the attempt without readings that are cut off, or without the one that is false, if that explains it.

    A wide tip above few taxels may explain it, too.
    """
    found = clipped(one) or without_a_reading(one)
    if found is None:
        return one
    return _or_a_tip(one, found) if may_be_a_tip(one) else found


def _second(one: Attempt) -> Attempt | None:
    """Return the attempt with a second load where most is left apart from the first, if no more is left than noise."""
    from tactile.inverse.least_squares import second_numba  # as above

    fit, signals = one.fit, one.fit.signals
    if (
        signals.noise is None
        or not fit.excess > 0
        or len(fit.loads) > 1
        or fit.misfit <= SLIGHT
        or len(signals.seen) < TWO
    ):
        return None
    body = signals.strain, signals.layer, signals.tie
    k, force, part = second_numba.second_load(
        signals.seen, signals.felt, signals.scale, fit.loads[0], *body, BESIDE
    )  # fmt: skip
    if not (force > 0 and part > HINTED):
        return None
    both = np.concatenate([fit.loads, [[*signals.seen[k], 0.0, 0.0, force]]])
    two = replace(one, fit=fitted(signals, both), ambiguous=False)
    told = not two.fit.excess > 0 or two.left * EVIDENT < one.left
    return as_ranked(two) if told and _presses(two.fit) else None


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


def _or_a_tip(one: Attempt, found: Attempt) -> Attempt:
    """Return what was found without a taxel, or the one load if a wide tip explains much better; ambiguous if alike."""
    if len(one.fit.loads) > 1 or len(found.fit.loads) > 1 or one.fit.misfit > POINT:
        return found
    tip = left_by_a_tip(one)
    if tip * RIVALS < found.left:
        return one
    return found if found.left * RIVALS < tip else replace(found, ambiguous=True)


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
