"""Normal-to-shear sensitivity beta_ns of a taxel from the extrema of curves fitted to a scan."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from cnnsim.support import Floats, InputError
from tactile.calibration.scan_fit import ASIDE, CURVES, DEPTH, MIDDLE, ScanFit, curves, fit_scan

EXTREMA_RATIO = 25 * np.sqrt(5) / 24
"""|u_zz(x = 0)| / |u_xz(x = z / 2)| on the line y = 0 under a normal load: eq. (18)."""
FINE = {"xatol": 1e-10}
LEAST = 11
"""Least number of samples of a scan."""
SURE = 5.0
"""Least ratio of beta_ns to its standard deviation."""
BEYOND = 0.6
"""Least length [depths] of the scan on either side of the taxel: the extrema of the shear are at half a depth."""


@dataclass(frozen=True)
class Sensitivity:
    """beta_ns and its standard deviation; negative for shear of opposite sign."""

    beta: float
    sigma: float


def beta_from_scan(shear: ArrayLike, normal: ArrayLike) -> Sensitivity:
    """Return beta_ns from a scan with a constant normal load along y = 0, over the taxel.

        beta_ns = (|S_n|max / |T_x|max) / (25 sqrt(5) / 24)

    The maxima are those of smooth curves through all samples (`tactile.calibration.scan_fit`), so noise is averaged.
    The sign is that of a scan toward growing x.

    Arguments: ``shear``, ``normal`` (n,) readings T_x, S_n at equally spaced places along the scan.

    Raises:
        InputError: shapes that differ, numbers that are not finite, a scan without all three extrema inside.

    Source: Vasarhelyi, Fodor, Roska, eqs (1), (18).
    """
    t, s = np.asarray(shear, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    if t.ndim != 1 or t.shape != s.shape:
        raise InputError(f"shear of shape {t.shape} and normal of shape {s.shape}, two equal (n,) wanted")
    shear_unit, normal_unit = scaled(t, s)
    scan = np.array([t / shear_unit, np.zeros(t.size), s / normal_unit])
    fit = fit_scan(np.arange(t.size, dtype=np.float64), scan, None)
    return sensitivity(fit, t.size - 1, normal_unit / shear_unit)


def scaled(t: Floats, s: Floats) -> tuple[float, float]:
    """Return the range of the shear (n,) along a scan, and its largest normal reading (n,).

    Raises:
        InputError: numbers that are not finite, too few, no signal.
    """
    if not (np.isfinite(t).all() and np.isfinite(s).all()):
        raise InputError("the scan has NaN or infinite readings, finite ones wanted")
    if not t.size or not t.any() or not s.any():
        raise InputError("the scan has no signal, one over a loaded taxel wanted")
    if t.size < LEAST:
        raise InputError(f"{t.size} samples, at least {LEAST} wanted")
    if not np.ptp(t):
        raise InputError(f"the shear is {t[0]:g} throughout the scan, one over a loaded taxel wanted")
    return float(np.ptp(t)), float(np.abs(s).max())


def sensitivity(fit: ScanFit, last: float, unit: float) -> Sensitivity:
    """Return beta_ns of a scan's curves, over places in samples from 0 to ``last``; ``unit`` of S_n over that of T.

    Raises:
        InputError: a scan without all three extrema inside, or noise only.
    """
    middle, depth = fit.parameters[[MIDDLE, DEPTH]].tolist()
    depth = abs(depth)
    if middle < BEYOND * depth or middle > last - BEYOND * depth:
        raise InputError(
            f"the taxel lies at sample {middle:.1f} of {last + 1:.0f} and is {depth:.1f} samples deep: the scan must"
            f" go on for {BEYOND:g} depths on either side, beyond every extremum"
        )
    beta, sigma = extrema(fit.parameters), float(fit.spread(lambda one: np.array([extrema(one)]))[0])
    if not abs(beta) > SURE * sigma:
        raise InputError(f"beta_ns {beta * unit:.3g} +- {sigma * unit:.3g}: a signal above its noise wanted")
    return Sensitivity(beta * unit, sigma * unit)


def extrema(parameters: Floats) -> float:
    """Return beta_ns of curves along the line over the taxel, in their own units."""
    over = parameters.copy()
    over[ASIDE] = 0.0
    half = (parameters.size - CURVES + 1) // 2
    swing = curves(over, np.array([0.5]))[0, 0]
    if half > 2:
        top = minimize_scalar(
            lambda x: -abs(curves(over, np.array([x]))[0, 0]), bounds=(0.1, 1.2), method="bounded", options=FINE
        )
        swing = curves(over, np.array([top.x]))[0, 0]
    return float(abs(parameters[CURVES]) / swing / EXTREMA_RATIO)
