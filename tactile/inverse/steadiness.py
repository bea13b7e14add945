"""Steadiness of a place: how far it moves where the normal signals, or one of the strongest taxels, are not asked.

Covers that are thin and tips that are wide bend the signals alike in every frame: what they leave unexplained is no
chance, and says less of the place than noise of that size would. On a thin cover the shear still points to the load
while the normal signals do not fit, so the two disagree.
"""

import math

import numpy as np

from tactile.elastic.layer_field import HALF_SPACE
from tactile.inverse.attempt import DOUBT, Attempt
from tactile.inverse.least_squares.fit import TIED, Fit, Signals, fitted, made

DIFFERS, MOVES = 0.2, 0.6
"""A place that lies so many depths from that by shear alone, or moves so far without a taxel, is in doubt."""
NOTICED = 0.2
"""From a layer that moves the place by so large a part of its distance one taxel cannot tell what shear does."""
OUTSIDE = 2.0
"""Square of the depths from which a place is outside."""
LEANT_ON = 4
"""The strongest taxels, of which one may hold the place alone."""
FEW = 16
"""Among more taxels none of them does."""
BENT = 0.02
"""From this share on three taxels, and those that others were left out for, are asked: they fit nearly anything."""


def unsteady(found: Attempt, *, left_out: bool) -> bool:
    """Whether the place of the only load hangs on what the load does not explain.

    ``left_out``: some taxel contradicts all others and was not fitted.
    """
    fit = found.fit
    count = len(fit.signals.seen)
    if len(fit.signals.layer) and fit.signals.tie.any() and len(fit.loads) == 1 and _hangs_on_shear(fit):
        return True
    if len(fit.loads) > 1 or count == 1 or fit.misfit <= (BENT if left_out or count < 4 else DOUBT):
        return False
    if _moved(fit, _shear_alone(fit.signals)) > DIFFERS:
        return True
    return count <= FEW and any(_moved(fit, fit.signals.without(k)) > MOVES for k in range(min(count, LEANT_ON)))


def _hangs_on_shear(fit: Fit) -> bool:
    """Whether shear that the taxels cannot tell, and is taken to be none, may move the place: on a layer it does.

    A place outside may be another one altogether: two taxels on the bottom have four numbers for it, which always fit.
    """
    signals, (x, y, _, _, f) = fit.signals, fit.loads[0]
    if ((signals.seen - (x, y)) ** 2).sum(axis=1).min() >= OUTSIDE:
        return True
    xx, xy, yy = (signals.tie / TIED).tolist()
    # one taxel's three numbers fit several places; the half-space's is the one that no shear moves
    alone, far = len(signals.seen) == 1, NOTICED * math.dist((x, y), signals.seen[0])
    if alone and _moved(fit, signals._replace(layer=HALF_SPACE)) > far:
        return True
    ways = [(xx, xy), (xy, yy)] if xx + yy > 1.5 else [(math.sqrt(xx), math.copysign(math.sqrt(yy), xy))]
    for q, r in ways:
        for half in (-f / 2, f / 2):
            sheared = made(signals, np.array([[x, y, q * half, r * half, 0.0]]))
            if _moved(fit, signals._replace(felt=signals.felt - sheared)) > DIFFERS:
                return True
    return False


def _shear_alone(signals: Signals) -> Signals:
    felt, scale = signals.felt.copy(), signals.scale.copy()
    felt[:, 2] = scale[:, 2] = 0.0
    return signals._replace(felt=felt, scale=scale, lost=int(np.count_nonzero(scale == 0)))


def _moved(fit: Fit, signals: Signals) -> float:
    """Return how far [depths] the place lies from that of a fit to these signals."""
    return math.dist(fitted(signals, fit.loads).loads[0, :2], fit.loads[0, :2])
