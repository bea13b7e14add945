"""Radial correction of located loads by their distance from the taxel, measured by a scan over known places.

"The deviation between the measured strain distributions and the model is a function of distance from the center of the
taxel. This function is not known theoretically, but it can be measured point by point as calibration data."
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from cnnsim.operations.cellwise import Planes
from cnnsim.support import Floats, InputError
from tactile.inverse.validity import Validity

EVERYWHERE = 1.0
"""[m] Measured radius of a correction that applies to all answers."""
LOCATED = (Validity.INSIDE, Validity.OUTSIDE)
LEAST = 3
"""Least number of answers in a ring."""
SURE = 2.0
"""Standard errors by which the located radius must grow from ring to ring."""


@dataclass(frozen=True)
class RadialCorrection:
    """The true distance from the taxel and the factor of the force, as functions of the located distance.

    Calling it corrects the planes (dx, dy, force, validity) of ``invert_strain`` or ``invert_stress``. Beyond the last
    measured radius the answer is INVALID and 0. Monotone cubic between the measured radii.

    Arguments: ``found``, ``true`` (n,) growing radii from 0 [m]; ``force`` (n,) true over located force.

    Raises:
        InputError: lengths that differ, fewer than 2 radii, radii that do not start at 0 or do not grow, factors that
            are not positive.

    Source: Vasarhelyi, Fodor, Roska, sect. 4, below Fig. 7.
    """

    found: Sequence[float]
    true: Sequence[float]
    force: Sequence[float]

    def __post_init__(self) -> None:
        if not len(self.found) == len(self.true) == len(self.force) >= 2:
            raise InputError(
                f"{len(self.found)} located and {len(self.true)} true radii with {len(self.force)} factors,"
                " equally many and at least 2 wanted"
            )
        for name, radii in (("located", self.found), ("true", self.true)):
            if radii[0] != 0 or not (np.diff(radii) > 0).all() or not np.isfinite(radii).all():
                raise InputError(f"{name} radii {list(radii)}, growing ones from 0 wanted")
        if not all(0 < factor < np.inf for factor in self.force):
            raise InputError(f"factors of the force {list(self.force)}, positive ones wanted")

    @classmethod
    def constant(cls, factor: float) -> Self:
        """Return the correction that multiplies every force and keeps the places."""
        return cls((0.0, EVERYWHERE), (0.0, EVERYWHERE), (factor, factor))

    def of_signs(self, planes: Planes) -> Planes:
        """Return the corrected planes of pressing loads (4), or of pressing and pulling loads (8).

        A far pressing load and a near pulling load cause the same readings. Where the first is beyond the measured
        radii, the second is used only together with answers of other taxels.
        """
        corrected = [self(planes[k : k + 4]) for k in range(0, len(planes), 4)]
        if len(corrected) == 2:
            (*_, pressing), (*place, pulling) = corrected
            alone = np.isin(pressing, LOCATED) | np.isin(pulling, LOCATED)
            if np.count_nonzero(alone) == 1:
                lost = alone & np.isin(planes[3], LOCATED) & (pressing == Validity.INVALID)
                corrected[1] = *place, np.where(lost, Validity.INVALID, pulling)
        return tuple(plane for one in corrected for plane in one)

    @cached_property
    def _curves(self) -> tuple[PchipInterpolator, PchipInterpolator]:
        return PchipInterpolator(self.found, self.true), PchipInterpolator(self.found, self.force)

    def __call__(self, planes: Planes) -> Planes:
        """Return the planes corrected."""
        dx, dy, force, validity = planes
        radius, factor = self._curves
        rho = np.hypot(dx, dy)
        answered = (validity != Validity.NO_LOAD) & (validity != Validity.INVALID)
        known = answered & (rho <= self.found[-1])
        safe = np.where(known, rho, 0.0)
        stretch = np.where(safe > 0, radius(safe) / np.where(safe > 0, safe, 1.0), float(radius.derivative()(0.0)))
        return (
            np.where(known, dx * stretch, 0.0),
            np.where(known, dy * stretch, 0.0),
            np.where(known, force * factor(safe), 0.0),
            np.where(answered & ~known, float(Validity.INVALID), validity),
        )


def radial_from_scan(found: ArrayLike, true: ArrayLike, forces: ArrayLike, load: float, rings: int) -> RadialCorrection:
    """Return the correction measured by a scan over known places.

    The answers are sorted into rings of equal width by their true distance; a ring's located radius is the mean of the
    answers' components along the true direction, which noise across it does not lengthen.

    Arguments: ``found``, ``true`` (n, 2) places [m] seen from the taxel; ``forces`` (n,) located [N]; ``load`` [N];
    ``rings``: their number, with at least 3 answers each.

    Raises:
        InputError: shapes that do not match, numbers that are not finite, a ring with too few answers (the scan has
            too few, or misses the taxel), a located radius that does not grow from ring to ring (noise, or a map that
            folds: scan a smaller region), forces that do not press.
    """
    at, place, pressing = (np.asarray(values, np.float64) for values in (found, true, forces))
    if place.ndim != 2 or place.shape[1] != 2 or at.shape != place.shape or pressing.shape != place.shape[:1]:
        raise InputError(
            f"located places {at.shape}, true places {place.shape} and forces {pressing.shape}, (n, 2), (n, 2) and (n,)"
            " wanted"
        )
    if not all(np.isfinite(values).all() for values in (at, place, pressing)):
        raise InputError("numbers in the scan that are not finite; finite ones wanted")
    if rings < 1 or not load > 0:
        raise InputError(f"{rings} rings under {load} N, at least one ring and a load that presses wanted")
    rho = np.hypot(place[:, 0], place[:, 1])
    away = rho > 0
    rho, at, place, pressing = rho[away], at[away], place[away], pressing[away]
    reach = float(rho.max(initial=0.0))
    ring = np.minimum((rho / (reach or 1.0) * rings).astype(int), rings - 1)
    count = np.bincount(ring, minlength=rings)
    if count.min() < LEAST:
        k = int(count.argmin())
        span = f"from {k * reach / rings * 1e6:.4g} to {(k + 1) * reach / rings * 1e6:.4g} um"
        raise InputError(f"{count[k]} answers {span} from the taxel, at least {LEAST} in every ring wanted")
    along = (at * place).sum(axis=1) / rho
    mean, true_mean, force = (np.bincount(ring, values) / count for values in (along, rho, pressing))
    residual = along - rho * (mean / true_mean)[ring]
    error = np.sqrt(np.bincount(ring, residual**2) / count / (count - 1))
    _growing(mean, true_mean, SURE * error)
    if force.min() <= 0:
        raise InputError(f"a located force of {force.min():.3g} N under {load} N, one that presses wanted")
    factor = load / force
    return RadialCorrection((0.0, *mean.tolist()), (0.0, *true_mean.tolist()), (float(factor[0]), *factor.tolist()))


def _growing(found: Floats, true: Floats, margin: Floats) -> None:
    before, slack = np.concatenate([[0.0], found[:-1]]), np.concatenate([[0.0], margin[:-1]])
    back = found - before <= np.hypot(margin, slack)
    if back.any():
        k = int(back.argmax())
        raise InputError(
            f"located {found[k] * 1e6:.4g} um from the taxel after {before[k] * 1e6:.4g} um, where the needle was "
            f"{true[k] * 1e6:.4g} um away: a located radius that grows beyond its noise wanted"
        )
