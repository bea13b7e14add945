"""Stability of a located place: how far it moves without the normal signals, or without one of the strongest taxels.

Thin covers and wide tips bend the signals alike in every frame, so the place is less certain than if the residuals
were noise. On a thin cover the shear still points to the load while the normal signals do not fit.
"""

import math

import numpy as np

from tactile.elastic.layer_field import HALF_SPACE
from tactile.inverse.limits import DOUBT, STRONGEST, UNOBSERVABLE
from tactile.inverse.single_fit import LoadFit, fitted, made
from tactile.inverse.weights import TaxelSignals

BY_SHEAR, BY_TAXEL = 0.2, 0.6
"""Distances [depths] from the place by shear alone, and from that without a taxel, from which a place is in doubt."""
BY_LAYER = 0.2
"""Part of its distance by which the layer may move the place that one taxel locates."""
FEW = 16
"""Number of taxels up to which one of them may decide the place."""
FIT_ANYTHING = 0.02
"""Misfit from which the place of three taxels, or one with a taxel left out, is tested: they fit nearly anything."""


def unstable(fit: LoadFit, *, left_out: bool) -> bool:
    """Whether the place of the only load depends on unexplained signals; ``left_out``: a taxel is left out already."""
    count = len(fit.signals.seen)
    if len(fit.signals.layer) and fit.signals.tie.any() and len(fit.loads) == 1 and _depends_on_shear(fit):
        return True
    if len(fit.loads) > 1 or count == 1 or fit.misfit <= (FIT_ANYTHING if left_out or count < 4 else DOUBT):
        return False
    if fit.signals.noise is not None and not fit.excess > 0:
        return False
    normal = np.broadcast_to([False, False, True], fit.signals.measured.shape)
    if _moved(fit, fit.signals.less(normal)) > BY_SHEAR:
        return True
    return count <= FEW and any(_moved(fit, fit.signals.without(k)) > BY_TAXEL for k in range(min(count, STRONGEST)))


def _depends_on_shear(fit: LoadFit) -> bool:
    """Whether shear that the taxels do not measure may move the place: on a layer it does.

    A place outside is never certain: two taxels on the bottom give four numbers for it, which always fit.
    """
    signals, (x, y, _, _, f) = fit.signals, fit.loads[0]
    if ((signals.seen - (x, y)) ** 2).sum(axis=1).min() >= 2:
        return True
    # three numbers of one taxel fit several places; the half-space's is the one that shear does not move
    alone, far = len(signals.seen) == 1, BY_LAYER * math.dist((x, y), signals.seen[0])
    if alone and _moved(fit, signals._replace(layer=HALF_SPACE)) > far:
        return True
    xx, xy, yy = (signals.tie / UNOBSERVABLE).tolist()
    ways = [(xx, xy), (xy, yy)] if xx + yy > 1.5 else [(math.sqrt(xx), math.copysign(math.sqrt(yy), xy))]
    for q, r in ways:
        for half in (-f / 2, f / 2):
            sheared = made(signals, np.array([[x, y, q * half, r * half, 0.0]]))
            if _moved(fit, signals._replace(measured=signals.measured - sheared)) > BY_SHEAR:
                return True
    return False


def _moved(fit: LoadFit, signals: TaxelSignals) -> float:
    """Return the distance [depths] of the place from that of a fit to these signals."""
    return math.dist(fitted(signals, fit.loads).loads[0, :2], fit.loads[0, :2])
