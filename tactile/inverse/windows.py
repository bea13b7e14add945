"""Loads far from each other on a large pad: each is located from the taxels around it, those near each other together.

What a load makes falls to a hundredth within `WINDOW` depths, so taxels farther away say nothing of it. The work grows
with the loads, and any number of them is found. Of those so near that their windows meet a few are told apart at once
(`several`); more are split, each with the taxels nearest to it, and fitted to what the others leave.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cnnsim.support import Flags, Floats, Integers
from tactile.inverse.alternatives import explained
from tactile.inverse.attempt import DOUBT, UNSURE, Attempt, Taxels
from tactile.inverse.least_squares.fit import fitted, made
from tactile.inverse.several import MOST
from tactile.inverse.validity import Validity
from tactile.inverse.weights import Weights

LARGE = 16
"""Taxels a side above which peaks are looked for: below, all taxels are near every load."""
WINDOW = 2.5
"""Half the side of a window, in depths."""
LEAST = 0.05
"""A peak of a load is so high, over the highest: side lobes of one that shears and presses are not."""
QUIET, SURE = 0.1, 12.0
"""A peak is so many times what so many of the taxels feel at most: among a million of noise none is."""
NOISE = 6.0
"""Of normal noise nothing is so many standard deviations large on a million taxels."""
COARSE = 1.5
"""Pitches [depths] up to which a load is felt by the neighbours of the taxel that feels it most, ..."""
ALONE = 0.05
"""... of which none feels less than this part of it: else that taxel reads falsely."""
SWEEPS = 3
"""How often the loads are fitted anew to what the others, as they stand then, leave: near ones change each other."""
REACH = 12.0
"""What loads farther away than so many depths make in a window is not taken off: less than 1e-4."""


class Window(NamedTuple):
    """The taxels of some loads near each other, with the answer: ``corner`` is where their array begins in the pad."""

    taxels: Taxels
    found: Attempt
    corner: tuple[int, int]


def may_be_many(taxels: Taxels, one: Attempt) -> bool:
    """Whether a pad is so large that peaks are looked for, and one load leaves as much at a taxel as another's makes.

    What is within the noise that is left is none.
    """
    if min(taxels.shape) <= LARGE or _pitch(taxels) > COARSE * taxels.depth:
        return False
    fit = one.fit
    left = float(np.abs(fit.rest).max())
    if left < LEAST / 2:  # what reads falsely leaves more
        return False
    return fit.foreign is not None or not left < NOISE * (fit.chi / max(fit.free, 1)) ** 0.5


def windows_of(at: Floats, planes: Floats, taxels: Taxels) -> list[Window] | None:
    """Return the windows of a pad and what each of them finds, the strongest first; None if one has all the loads.

    ``at`` (rows, cols, 2) [m], ``planes`` (families, 4, rows cols) of all taxels.
    """
    groups = _groups(_peaks(taxels), at, taxels)
    if len(groups) < 2:
        return None
    found = [window for group in groups for window in _located(group, at, planes, taxels)]
    alone = found
    for _ in range(SWEEPS):
        found = [window._replace(found=_without(window, found)) for window in alone]
    return sorted(found, key=lambda window: -window.found.top) or None


def false_taxels(taxels: Taxels) -> tuple[tuple[int, int], ...]:
    """Return the taxels (row, column) of a pad that feel much where no neighbour feels anything: they read falsely."""
    lone = _peaks(taxels, alone=True)
    return tuple((int(row), int(col)) for row, col in lone)


def _peaks(taxels: Taxels, *, alone: bool = False) -> Integers:
    """Return the places (n, 2) as rows and columns where taxels feel more than all others within a depth.

    Where none of the neighbours feels anything it is no load; ``alone``: those.
    """
    from scipy.ndimage import maximum_filter  # slow to import, and only for large pads

    height = taxels.peak.reshape(taxels.shape)
    near = 2 * max(1, round(taxels.depth / _pitch(taxels))) + 1
    floor = max(LEAST * float(height.max()), SURE * float(np.quantile(height, QUIET)))
    around = np.ones((3, 3), bool)
    around[1, 1] = False
    felt = maximum_filter(height, footprint=around, mode="constant") > ALONE * height
    return np.argwhere((maximum_filter(height, near) == height) & (height > floor) & (felt ^ alone))


def _pitch(taxels: Taxels) -> float:
    return float(np.abs(taxels.at[1] - taxels.at[0]).max())


def _groups(peaks: Integers, at: Floats, taxels: Taxels) -> list[Integers]:
    """Return the peaks whose windows meet, group by group."""
    from scipy.spatial import cKDTree  # as above

    places = at[peaks[:, 0], peaks[:, 1]] / taxels.depth
    belongs = np.arange(len(peaks))
    for a, b in sorted(cKDTree(places).query_pairs(2 * WINDOW, p=np.inf)) if len(peaks) > 1 else ():
        belongs[belongs == belongs[b]] = belongs[a]
    return [peaks[belongs == one] for one in np.unique(belongs)]


def _located(group: Integers, at: Floats, planes: Floats, taxels: Taxels) -> list[Window]:
    """Return the window of a group that explains what is felt there by loads in it, else one of each of its peaks."""
    window = _window(group, None, at, planes, taxels) if len(group) <= MOST else None
    if window is not None and _holds(window, group) and (len(group) == 1 or window.found.fit.misfit <= DOUBT):
        return [window]
    parts = (_window(*part, at, planes, taxels) for part in _split(group, at, taxels))
    return [window for window in parts if window is not None]


def _holds(window: Window, group: Integers) -> bool:
    """Whether all loads that were found lie in reach of a peak: those beyond stand for what others make."""
    cells, fit = window.taxels, window.found.fit
    peaks = cells.at[(group[:, 0] - window.corner[0]) * cells.shape[1] + group[:, 1] - window.corner[1]] / cells.depth
    places = fit.loads[:, :2] + cells.at[window.found.order[0]] / cells.depth - fit.signals.seen[0]
    return bool((np.abs(places[:, None] - peaks).max(axis=2).min(axis=1) <= WINDOW).all())


def _split(group: Integers, at: Floats, taxels: Taxels) -> list[tuple[Integers, Flags]]:
    """Return each peak of a large group by itself, with the taxels that are nearer to it than to the others."""
    from scipy.spatial import cKDTree  # as above

    nearest = cKDTree(at[group[:, 0], group[:, 1]]).query(taxels.at)[1].reshape(taxels.shape)
    return [(group[k : k + 1], nearest == k) for k in range(len(group))]


def _window(group: Integers, own: Flags | None, at: Floats, planes: Floats, taxels: Taxels) -> Window | None:
    """Return the window of some peaks, of which only the taxels ``own`` are used if they are given."""
    (rows, cols), depth = taxels.shape, taxels.depth
    reach = int(np.ceil(WINDOW * depth / _pitch(taxels)))
    used: Flags = np.zeros((rows, cols), bool)
    for i, j in group.tolist():
        used[max(0, i - reach) : i + reach + 1, max(0, j - reach) : j + reach + 1] = True
    if own is not None:
        used &= own
    (r0, c0), (r1, c1) = np.maximum(group.min(axis=0) - reach, 0), group.max(axis=0) + reach + 1
    part = np.s_[r0:r1, c0:c1]
    cut = planes.reshape(*planes.shape[:2], rows, cols)[:, :, r0:r1, c0:c1].copy()
    cut[:, 3, ~used[part]] = Validity.NO_LOAD
    weights = Weights(
        taxels.noise, taxels.scale.reshape(rows, cols, 3)[part].reshape(-1, 3),
        taxels.trust.reshape(rows, cols)[part].ravel(),
    )  # fmt: skip
    places = np.ascontiguousarray(at[part])
    cells = Taxels(
        places, np.ascontiguousarray(cut.reshape(*planes.shape[:2], -1)), depth, taxels.strain, weights, taxels.layer
    )
    if not cells.order.size:
        return None
    found = cells.attempt(cells.order)
    if own is None and cells.order.size >= 4:  # between others nobody looks for more: what is left may be theirs
        found = explained(cells, found)
    return Window(cells, found, (int(r0), int(c0)))


def _without(window: Window, windows: list[Window]) -> Attempt:
    """Return the fit to a window's signals less what the loads of the other windows make there."""
    found, signals = window.found, window.found.fit.signals
    others = np.array(
        [load for other in windows if other.taxels is not window.taxels for load in _seen_from(window, other)]
    )
    if not len(others):
        return found
    less = signals._replace(felt=signals.felt - made(signals, others))
    fit = fitted(less, found.fit.loads)
    if len(fit.loads) == 1 and fit.misfit > DOUBT:  # others may have drawn the first place away
        fit = min(fit, fitted(less, less.seen[:1]), key=lambda one: one.chi)
    if fit.chi > found.fit.chi:
        return found
    return Attempt(found.order, fit, found.top, found.ambiguous or fit.unsure > UNSURE, found.clipped, found.false)


def _seen_from(window: Window, other: Window) -> Iterator[Floats]:
    """Yield the loads of another window that are near enough, as this one's fit has places and sizes."""
    here, there = (
        one.taxels.at[one.found.order[0]] / one.taxels.depth - one.found.fit.signals.seen[0] for one in (window, other)
    )
    for load in other.found.fit.loads:
        place = load[:2] + there - here
        if np.abs(window.found.fit.signals.seen - place).max(axis=1).min() < REACH:
            yield np.concatenate([place, load[2:] * other.found.top / window.found.top])
