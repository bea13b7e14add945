"""Choice of a model for the signals of all taxels: one load, a false or clipped reading, a false taxel, several loads.

The simplest model is kept unless another one leaves a much smaller residual. Where the residuals of two models are
similar, the answer is ambiguous.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.inverse.limits import (
    CLIPPED_SIGMAS,
    DOUBT,
    EQUAL,
    FALSE_SIGMAS,
    FALSE_TIMES,
    FEW_FREE,
    LOADS_APART,
    NEAR_END,
    PATCH,
    POINT,
    RIVALS,
    SECOND_SHARE,
    SECOND_TIMES,
    SLIGHT_MISFIT,
)
from tactile.inverse.multi_fit import EXPLAINED, ranked, several, simplest
from tactile.inverse.single_fit import NO_DIFFERENCE, Candidate, LoadFit, Taxels, fitted, made
from tactile.inverse.wide_tip import may_be_wide, variance_of_wide

FEW, NO_LESS = 16, 0.1
"""With at most `FEW` taxels all places are tried in doubt; a fit counts as better if it leaves `NO_LESS` of a variance
less: fits that end at one place differ by a hundredth."""
ANY_OF, SHARE, WORST = 8, 0.25, 13.5
"""One of up to `ANY_OF` taxels may always explain the misfit; of more, one with `SHARE` of chi^2, or with `WORST`
variances where the noise is unknown: noise leaves as much at the worst of 9 to 25 taxels in 1 frame of 20."""
FRICTION = 2.0
"""Largest ratio of shear to normal force of a second load; what exceeds it is a false taxel."""
SECOND_FROM = 6
"""Number of taxels from which a second load is tested where the noise is known."""


def best_model(taxels: Taxels, one: Candidate) -> Candidate:
    """Return the single load, or a model that explains the signals much better; ambiguous if two explain them alike."""
    first, one = one, _without_certain(one)
    if one.fit.excess > 0 or one.fit.misfit > SLIGHT_MISFIT:
        one = _without_reading(one)
        if (two := _second(one)) is not None:
            return _or_false_taxel(two)
    if one.fit.misfit <= DOUBT and one.fit.foreign is None:
        return one
    if one.fit.misfit > POINT or one.order.size <= FEW:
        again = taxels.single(one.order, thorough=True)
        if (first.fit.chi - again.fit.chi) * first.fit.free > NO_LESS * first.fit.chi:
            one = _without_reading(_without_certain(again))
    if (one.fit.misfit <= DOUBT or not _one_taxel(one)) and one.fit.foreign is None:
        return one
    suspects = {0, *one.fit.worst[:3].tolist()} if one.order.size > 4 else set(range(4))
    if one.fit.foreign is not None:
        suspects.add(one.fit.foreign)
    tried = [taxels.single(np.delete(one.order, k)) for k in sorted(suspects)]
    best = min((_without_clipped(other) or other for other in tried), key=lambda other: other.left)
    ways = [one]
    if best.fit.misfit < POINT and simplest([one, best]) is best:
        ways.append(best)
    if ways[-1].fit.misfit > (PATCH if len(ways) == 1 and one.fit.foreign is None else EXPLAINED):
        ways += several(taxels, one)
    found = simplest(ways)
    found = _without_clipped(found) or found
    if found.order.size < one.order.size:
        return _or_wide(one, _or_second(taxels, one, found))
    return _or_false_taxel(found)


def _one_taxel(one: Candidate) -> bool:
    """Whether a single outlier taxel may explain the residuals."""
    if one.order.size <= ANY_OF:
        return True
    fit = one.fit
    worst, share = fit.rest[fit.worst[0]], SHARE if fit.signals.noise is not None else max(SHARE, WORST / fit.free)
    return bool((worst @ worst) > share * fit.chi) or fit.misfit > PATCH


def _largest(one: Candidate, near: float) -> Flags:
    """Return which readings (n, 3) are the largest, up to the relative distance ``near``."""
    signals = one.fit.signals
    raw = np.abs(signals.measured) / np.where(signals.scale > 0, signals.scale, np.inf)
    largest: Flags = raw >= raw.max() * (1 - near)
    return largest


def _without_certain(one: Candidate) -> Candidate:
    """Return the candidate without a dead reading or without equal largest ones, which noise never makes.

    Ambiguous where too few others are left.
    """
    from tactile.inverse.single_fit_numba import equal_readings  # numba is slow to import

    fit, signals = one.fit, one.fit.signals
    if one.clipped or one.false or fit.free < 1 or fit.chi <= NO_DIFFERENCE * fit.whole:
        return one
    zero, ends = equal_readings(signals.measured, signals.scale)
    if ends > 1:
        return _without_largest(one, _largest(one, EQUAL))
    if zero < 0:
        return one
    dead = np.arange(signals.measured.size).reshape(-1, 3) == zero
    starts = fit.loads, fitted(signals.without(zero // 3), fit.loads).loads
    best = min((fitted(signals.less(dead), start) for start in starts), key=lambda found: found.chi)
    return replace(one, fit=best, ambiguous=False, false=(int(signals.cells[zero // 3]),))


def _without_largest(one: Candidate, cut: Flags) -> Candidate:
    cells = tuple(one.fit.signals.cells[cut.any(axis=1)].tolist())
    if one.fit.free < cut.sum():
        return replace(one, ambiguous=True, clipped=cells)
    return replace(one, fit=fitted(one.fit.signals.less(cut), one.fit.loads), clipped=cells)


def _without_clipped(one: Candidate) -> Candidate | None:
    """Return the candidate without the largest readings if they are clipped: larger ones explain all the others."""
    certain = _without_certain(one)
    if certain.clipped != one.clipped:
        return certain
    fit, noise = one.fit, one.fit.signals.noise or 0.0
    if one.clipped or one.false or fit.free <= FEW_FREE or (len(fit.loads) == 1 and not fit.tests[3]):
        return None
    cut = _largest(one, NEAR_END)
    found = _without_largest(one, cut)
    if not (made(fit.signals, found.fit.loads)[cut] / fit.signals.measured[cut] > 1).all():
        return None
    noise_alone = not found.fit.excess > 0 and fit.chi - found.fit.chi > (CLIPPED_SIGMAS * noise) ** 2 > 0
    return found if noise_alone or found.left * FALSE_TIMES < one.left else None


def _without_reading(one: Candidate) -> Candidate:
    """Return the candidate without clipped readings, or without a false one, if that explains the signals.

    A wide tip above few taxels may explain them, too.
    """
    found = _without_clipped(one) or _without_false(one)
    if found is None:
        return one
    return _or_wide(one, found) if may_be_wide(one.fit) else found


def _without_false(one: Candidate) -> Candidate | None:
    """Return the candidate without one reading of the strongest taxels if it contradicts all others.

    Ambiguous where another reading may be false instead, with a load at another place.
    """
    from tactile.inverse import residual_tests_numba as tests  # numba is slow to import

    fit, signals = one.fit, one.fit.signals
    if len(fit.loads) > 1 or one.clipped or one.false:
        return None
    loads, noise = np.empty((2, 5)), signals.noise or 0.0
    numbers = fit.loads[0], fit.chi, fit.free, noise, (fit.excess, fit.misfit, *fit.tests), loads
    said, k = tests.false_reading(signals[:6], *numbers)
    if said == tests.SOUND:
        return None
    false = np.arange(signals.measured.size).reshape(-1, 3) == k
    found, cell = fitted(signals.less(false), loads[:1]), (int(signals.cells[k // 3]),)
    ambiguous, read = said == tests.ONE_OF_TWO, signals.measured[false][0]
    if read and _largest(one, 0.0)[false][0] and made(signals, found.loads)[false][0] / read > 1:
        return replace(one, fit=found, ambiguous=ambiguous, clipped=cell)
    return replace(one, fit=found, ambiguous=ambiguous, false=cell)


def _second(one: Candidate) -> Candidate | None:
    """Return the candidate with a second load at the largest residual apart from the first, if that leaves noise."""
    from tactile.inverse.residual_tests_numba import second_load  # numba is slow to import

    fit, signals = one.fit, one.fit.signals
    slight = not fit.excess > 0 or fit.misfit <= SLIGHT_MISFIT
    if signals.noise is None or slight or len(fit.loads) > 1 or len(signals.seen) < SECOND_FROM:
        return None
    k, force, share = second_load(signals[:6], fit.loads[0], fit.covariance, fit.rest)
    if not (force > 0 and share > SECOND_SHARE):
        return None
    both = np.concatenate([fit.loads, [[*signals.seen[k], 0.0, 0.0, force]]])
    two = replace(one, fit=fitted(signals, both), ambiguous=False)
    enough = not two.fit.excess > 0 or two.left * SECOND_TIMES < one.left
    return replace(two, fit=ranked(two.fit)) if enough and _possible(two.fit) else None


def _possible(fit: LoadFit) -> bool:
    """Whether the last load is apart from the others and has no more shear than friction allows."""
    q, r, f = fit.loads[-1, 2:].tolist()
    gaps = np.hypot(*(fit.loads[:-1, :2] - fit.loads[-1, :2]).T)
    return bool(f > 0 and np.hypot(q, r) < FRICTION * f and gaps.min() >= LOADS_APART and np.isfinite(fit.spread).all())


def _or_second(taxels: Taxels, one: Candidate, found: Candidate) -> Candidate:
    """Return the model without a taxel, or the model with that taxel under another load."""
    gone = np.setdiff1d(one.order, found.order)
    if gone.size != 1:
        return found

    def rivals() -> Iterator[Candidate]:
        origin = _origin(taxels, one)
        known = found.fit.loads * [1, 1, *[found.top / one.top] * 3]
        known[:, :2] += _origin(taxels, found) - origin
        for dx, dy, force, _ in taxels.planes[:, :, int(gone[0])].tolist():
            if np.isfinite([dx, dy, force]).all():
                place = (taxels.at[gone[0]] + (dx, dy)) / taxels.depth - origin
                start = np.concatenate([known, [[*place, 0.0, 0.0, force / one.top]]])
                fit = fitted(one.fit.signals, start)
                if _possible(fit):
                    yield replace(one, fit=fit, ambiguous=False)

    rival = min(rivals(), key=lambda other: other.left, default=None)
    return found if rival is None else _surer(found, rival)


def _origin(taxels: Taxels, one: Candidate) -> Floats:
    return np.asarray(taxels.at[one.order[0]] / taxels.depth - one.fit.signals.seen[0])


def _or_false_taxel(found: Candidate) -> Candidate:
    """Return the loads that were found, or one less and a false taxel; ambiguous if both explain as much."""
    signals, loads = found.fit.signals, found.fit.loads
    if len(loads) < 2:
        return found
    rivals = []
    for k in range(len(loads)):
        near = int(((signals.seen - loads[k, :2]) ** 2).sum(axis=1).argmin())
        rivals.append(replace(found, fit=fitted(signals.without(near), np.delete(loads, k, axis=0))))
    return _surer(found, min(rivals, key=lambda other: other.left))


def _surer(found: Candidate, rival: Candidate) -> Candidate:
    """Return the one that leaves much less than the other, or what was found, ambiguous."""
    if rival.left * RIVALS < found.left:
        return rival
    more = rival.fit.chi * rival.top**2 - found.fit.chi * found.top**2
    sure = found.left * RIVALS < rival.left or more > FALSE_SIGMAS**2 * found.fit.variance * found.top**2
    return found if sure else replace(found, ambiguous=True)


def _or_wide(one: Candidate, found: Candidate) -> Candidate:
    """Return what was found, or the one load if a wide tip explains much better; ambiguous if both explain as much."""
    if len(one.fit.loads) > 1 or len(found.fit.loads) > 1 or one.fit.misfit > POINT:
        return found
    wide = variance_of_wide(one.fit) * one.top**2
    if wide * RIVALS < found.left:
        return one
    return found if found.left * RIVALS < wide else replace(found, ambiguous=True)
