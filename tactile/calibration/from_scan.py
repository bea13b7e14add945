"""Calibration from one straight scan over one taxel: beta_ns, depth, gains and radial correction."""

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

RELIABLE, FARTHEST = 0.75, 1.25
"""Distances [depths] within which speed and load are compared (150 um of the paper's 200), and within which the radial
correction is measured."""
PLACES = 101
"""Number of places within `RELIABLE`."""
ASIDE_MOST = 0.1
"""Largest distance [depths] of the scan line from the taxel: eq. (18) holds for y = 0."""
CUT = 4
"""Largest step [counts] next to 3 or more equal samples at a smooth rounded peak; that of a clipped peak is larger."""
RINGS, SAMPLES = 10, 6
"""Largest number of rings of the radial correction, and number of samples for each."""


def calibrate(
    times: ArrayLike,
    readings: ArrayLike,
    speed: float,
    load: float,
    depth: float,
    modulus: float,
    toward: tuple[float, float] | None = None,
) -> Calibration:
    """Return the calibration from a needle drawn straight over a taxel at a known speed with a known load.

    From smooth curves through all samples (`tactile.calibration.scan_fit`) follow, in this order: beta_ns from the
    extrema (eq. (18)); the depth for which the located needle has the known speed; the gains for which its located
    load near the taxel is the known one; the true distance for each located radius. Standard deviations are those of
    the curves.

    Arguments: ``times`` (n,) [s]; ``readings`` (n, 3) T_x, T_y, S_n less their tare; ``speed`` [m/s]; ``load`` [N];
    ``depth`` z [m], nominal; ``modulus`` E [Pa]; ``toward``: direction of the slide in the array's
    frame; by default it is found from the shear, whose sign is then assumed to be right.

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
        axis = _direction(read[:, :2], top)
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
    found, sigma = bench.gains_and_depth(fit.parameters), fit.spread(bench.gains_and_depth)
    gains, deeper = Gains(*found[:2].tolist()), float(found[2])
    if not deeper > SURE * sigma[2]:
        raise InputError(
            f"the depth is {deeper:.3g} +- {sigma[2]:.3g} m: a motion above {SURE:g} standard errors wanted"
        )
    aside = bench.aside(fit.parameters)
    if abs(aside) > ASIDE_MOST * deeper:
        raise InputError(
            f"the scan passes {aside * 1e6:.3g} um next to the taxel, at most {ASIDE_MOST * deeper * 1e6:.3g} um wanted"
        )
    x = (at - fit.parameters[MIDDLE]) * bench.step
    x = x[np.hypot(x, aside) <= FARTHEST * depth]
    places, forces = _located(bench.readings(fit.parameters, x), gains, deeper, modulus)
    radial = _radial(places, np.stack([x, np.full(x.size, aside)], axis=-1), forces, load)
    return Calibration(gains, deeper, radial, (float(sigma[0]), float(sigma[1]), float(sigma[2])))


class _Bench(NamedTuple):
    """Known parameters of a scan: step [m] between samples, load [N], nominal depth [m] and modulus [Pa] of the skin,
    units (3,) of the fitted readings, first and last place [samples], sign of a pressing load.
    """

    step: float
    load: float
    depth: float
    modulus: float
    units: Floats
    ends: tuple[float, float]
    inward: float

    def aside(self, parameters: Floats) -> float:
        """Return the distance [m] of the scan line from the taxel."""
        return float(parameters[ASIDE] * parameters[DEPTH]) * self.step

    def readings(self, parameters: Floats, x: Floats) -> Floats:
        """Return the readings (n, 3) along the scan, across it and normal, with the load at x (n,) [m] along it."""
        return curves(parameters, x / (parameters[DEPTH] * self.step)).T * self.units

    def gains_and_depth(self, parameters: Floats) -> Floats:
        """Return the shear gain, the normal gain and the depth [m] of these curves.

        Located lengths are proportional to the depth given to the inverse. Gains are computed from the curves, which
        have little noise: forces located from three noisy readings are biased upwards.
        """
        _, _, normal = self.units
        gains = Gains(extrema(parameters) * normal / self.units[0], self.inward)
        first, last = ((end - float(parameters[MIDDLE])) * self.step for end in self.ends)
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


def _direction(shear: Floats, top: int) -> Floats:
    """Return the direction of the scan: the shear along it changes sign at the taxel."""
    half = min(top, len(shear) - 1 - top)
    odd = shear[top : top + half + 1] - shear[top - half : top + 1][::-1]
    return np.asarray(np.linalg.svd(odd, full_matrices=False)[2][0])


def _radial(found: Floats, true: Floats, forces: Floats, load: float) -> RadialCorrection:
    """Return the radial correction with the largest number of rings that the noise permits."""
    rings = max(1, min(RINGS, len(found) // SAMPLES))
    while True:
        try:
            return radial_from_scan(found, true, forces, load, rings)
        except InputError:
            if rings == 1:
                raise
            rings -= 1


def _in_range(name: str, readings: Floats) -> None:
    """Refuse clipped readings: equal ones at an extremum next to a larger step than at a smooth peak."""
    count = np.diff(np.unique(readings)).min(initial=np.inf)
    for end in (readings.min(), readings.max()):
        at = np.flatnonzero(readings == end)
        run = max(np.split(at, np.flatnonzero(np.diff(at) > 1) + 1), key=len)
        neighbour = max(readings[[max(run[0] - 1, 0), min(run[-1] + 1, readings.size - 1)]], key=lambda r: abs(r - end))
        high = 2 * abs(end) >= np.abs(readings).max()
        if high and run.size >= 3 and abs(neighbour - end) > (CUT + 0.5) * count:  # whole counts, except rounding
            raise InputError(
                f"{run.size} consecutive {name} readings are {end:.4g}, the next one {neighbour:.4g}: clipped at the"
                " end of the sensor's range, or repeated; readings within the range wanted"
            )


def _located(readings: Floats, gains: Gains, depth: float, modulus: float) -> tuple[Floats, Floats]:
    """Return places (n, 2) [m] and forces (n,) [N] of a pressing load."""
    x, y, z = gains(readings).T
    dx, dy, force, _ = invert_strain(x, y, z, depth, modulus, 0.0, 1)
    return np.stack([np.asarray(dx), np.asarray(dy)], axis=-1), np.asarray(force)
