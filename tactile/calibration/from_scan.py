"""Calibration from one straight scan over one taxel: beta_ns, thickness constant, gains and radial correction."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats, InputError
from tactile.calibration.file import Calibration
from tactile.calibration.gains import Gains
from tactile.calibration.radial import RadialCorrection, radial_from_scan
from tactile.calibration.scan_fit import ASIDE, DEPTH, MIDDLE, curves, fit_scan
from tactile.calibration.sensitivity import SURE, extrema, scaled, sensitivity
from tactile.core.loads import COLUMNS, PLACE, F
from tactile.elastic.halfspace import point_load_strain
from tactile.inverse.taxel import invert_strain

RELIABLE, REACH = 0.75, 1.25
"""Depths from the taxel within which speed and load are compared (150 um of the paper's 200), radii measured."""
PLACES = 101
"""Places within them at which they are."""
BESIDE = 0.1
"""A scan that passes the taxel by more than so many depths is not along y = 0: eq. (18) does not hold for it."""
CUT = 4
"""A smooth peak, rounded to counts so that 3 samples or more share its top, falls by so many counts beside them or by
fewer; one that falls by more was cut off."""
RINGS, SAMPLES = 10, 6
"""Rings of the radial correction, fewer where a ring would have fewer samples."""


def calibrate(
    times: ArrayLike,
    readings: ArrayLike,
    speed: float,
    load: float,
    depth: float,
    modulus: float,
    toward: tuple[float, float] | None = None,
) -> Calibration:
    """Return the calibration from a needle that slides straight over a taxel, at a known speed, with a known load.

    Of smooth curves through all samples (`tactile.calibration.scan_fit`), in this order: beta_ns from the extrema
    (eq. (18)); the depth with which the needle moves at its speed; the gains with which it fits to its load near the
    taxel; how far it was when it was located at each radius. Their standard deviations follow from those of the curves.

    Arguments: ``times`` (n,) [s]; ``readings`` (n, 3) T_x, T_y, S_n less their tare; ``speed`` [m/s]; ``load`` [N];
    ``depth`` z [m], nominal; ``modulus`` E [Pa]; ``toward``: direction of the slide in the array's
    frame. Without it the direction is found from the shear, whose sign is then taken to be right.

    Raises:
        InputError: shapes that do not match, a speed, load, depth or modulus that is not positive, a scan that
            misses the taxel, is too short or too coarse, leaves the sensor's range, or noise only.

    Source: Vasarhelyi, Fodor, Roska, sects 3.3 and 4.
    """
    t, read = np.asarray(times, np.float64), np.asarray(readings, np.float64)
    if t.ndim != 1 or read.shape != (t.size, 3):
        raise InputError(f"times of shape {t.shape} and readings of shape {read.shape}, (n,) and (n, 3) wanted")
    if not (np.isfinite(t).all() and np.isfinite(read).all() and t.size):
        raise InputError(f"{t.size} readings, some not finite: at least one wanted and all finite")
    for name, value in (("speed", speed), ("load", load), ("depth", depth), ("modulus", modulus)):
        if not 0 < value < np.inf:
            raise InputError(f"{name} {value}, a positive number wanted")
    for name, column in zip(("shear", "shear", "normal"), read.T, strict=True):
        _in_range(name, column)
    top = int(np.abs(read[:, 2]).argmax())
    if toward is None:
        axis = _way(read[:, :2], top)
    elif not 0 < np.hypot(*toward) < np.inf:
        raise InputError(f"direction {toward}, a direction on the surface wanted")
    else:
        axis = np.divide(toward, np.hypot(*toward))
    shear, normal = scaled(read[:, :2] @ axis, read[:, 2])
    step = float(np.median(np.diff(t)))
    if not step > 0:
        raise InputError(f"times from {t[0]} s to {t[-1]} s do not grow; a scan that goes on wanted")
    at, units = (t - t[0]) / step, np.array([shear, shear, normal])
    fit = fit_scan(at, read.T / units[:, None], math.atan2(axis[1], axis[0]))
    fit = fit.sided if toward is None else fit
    sensitivity(fit, float(at[-1]), normal / shear)
    inward = 1.0 if read[top, 2] < 0 else -1.0  # strain is negative under a load, CONVENTIONS.md
    bench = _Bench(speed * step, load, depth, modulus, units, (at[0], at[-1]), inward)
    told, sigma = bench.told(fit.parameters), fit.spread(bench.told)
    gains, deeper = Gains(*told[:2].tolist()), float(told[2])
    if not deeper > SURE * sigma[2]:
        raise InputError(
            f"the depth is {deeper:.3g} +- {sigma[2]:.3g} m: a motion above {SURE:g} standard errors wanted"
        )
    aside = bench.aside(fit.parameters)
    if abs(aside) > BESIDE * deeper:
        raise InputError(
            f"the scan passes {aside * 1e6:.3g} um beside the taxel, at most {BESIDE * deeper * 1e6:.3g} um wanted"
        )
    x = (at - fit.parameters[MIDDLE]) * bench.way
    x = x[np.hypot(x, aside) <= REACH * depth]
    places, forces = _located(bench.readings(fit.parameters, x), gains, deeper, modulus)
    radial = _radial(places, np.stack([x, np.full(x.size, aside)], axis=-1), forces, load)
    return Calibration(gains, deeper, radial, (float(sigma[0]), float(sigma[1]), float(sigma[2])))


class _Bench(NamedTuple):
    """What is known of a scan: the needle's way [m] from sample to sample, its load [N], the skin's nominal depth [m]
    and modulus [Pa], the units (3,) of the fitted readings, where the scan begins and ends, which sign presses.
    """

    way: float
    load: float
    depth: float
    modulus: float
    units: Floats
    ends: tuple[float, float]
    inward: float

    def aside(self, parameters: Floats) -> float:
        """Return how far [m] the scan passes beside the taxel."""
        return float(parameters[ASIDE] * parameters[DEPTH]) * self.way

    def readings(self, parameters: Floats, x: Floats) -> Floats:
        """Return the readings (n, 3) along the scan, across it and normal, with the load at x (n,) [m] along it."""
        return curves(parameters, x / (parameters[DEPTH] * self.way)).T * self.units

    def told(self, parameters: Floats) -> Floats:
        """Return the gains of shear and normal, and the depth [m], that these curves tell.

        A located length is proportional to the depth that the inverse was given. Gains follow from the curves, which
        have little noise: forces located from three noisy readings each are larger on the mean.
        """
        _, _, normal = self.units
        gains = Gains(extrema(parameters) * normal / self.units[0], self.inward)
        first, last = ((end - float(parameters[MIDDLE])) * self.way for end in self.ends)
        x = np.linspace(max(-RELIABLE * self.depth, first), min(RELIABLE * self.depth, last), PLACES)
        readings = self.readings(parameters, x)
        places, _ = _located(readings, gains, self.depth, self.modulus)
        since = x - x.mean()
        deeper = self.depth * float(since @ since) / float(since @ places[:, 0])
        rows = np.zeros((x.size, 1, COLUMNS))
        rows[:, 0, PLACE], rows[:, 0, F] = np.stack([x, np.full(x.size, self.aside(parameters))], axis=-1), self.load
        true = point_load_strain((0.0, 0.0), deeper, rows, self.modulus)
        factor = float((true * true).sum() / (gains(readings) * true).sum())
        return np.array([gains.shear * factor, gains.normal * factor, deeper])


def _way(shear: Floats, top: int) -> Floats:
    """Return the direction of the scan: shear along it changes its sign at the taxel, shear across it does not."""
    half = min(top, len(shear) - 1 - top)
    odd = shear[top : top + half + 1] - shear[top - half : top + 1][::-1]
    return np.asarray(np.linalg.svd(odd, full_matrices=False)[2][0])


def _radial(found: Floats, true: Floats, forces: Floats, load: float) -> RadialCorrection:
    """Return the radial correction with as many rings as stand out of the noise."""
    rings = max(1, min(RINGS, len(found) // SAMPLES))
    while True:
        try:
            return radial_from_scan(found, true, forces, load, rings)
        except InputError:
            if rings == 1:
                raise
            rings -= 1


def _in_range(name: str, readings: Floats) -> None:
    """Refuse readings that stay at an extremum and then fall as no smooth signal does: the range ends there."""
    count = np.diff(np.unique(readings)).min(initial=np.inf)
    for end in (readings.min(), readings.max()):
        at = np.flatnonzero(readings == end)
        run = max(np.split(at, np.flatnonzero(np.diff(at) > 1) + 1), key=len)
        beside = max(readings[[max(run[0] - 1, 0), min(run[-1] + 1, readings.size - 1)]], key=lambda r: abs(r - end))
        high = 2 * abs(end) >= np.abs(readings).max()
        if high and run.size >= 3 and abs(beside - end) > (CUT + 0.5) * count:  # whole counts, less rounding
            raise InputError(
                f"{run.size} {name} readings on end are {end:.4g}, the one beside them {beside:.4g}: cut at the end of"
                " the sensor's range, or repeated; readings within the range wanted"
            )


def _located(readings: Floats, gains: Gains, depth: float, modulus: float) -> tuple[Floats, Floats]:
    """Places (n, 2) [m] and forces (n,) [N] of a pressing load."""
    x, y, z = gains(readings).T
    dx, dy, force, _ = invert_strain(x, y, z, depth, modulus, 0.0, 1)
    return np.stack([np.asarray(dx), np.asarray(dy)], axis=-1), np.asarray(force)
