"""Normal-to-shear sensitivity beta_ns of a taxel: a scan over it fitted as a whole, then the extrema of the fit."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike
from scipy.optimize import least_squares, minimize_scalar
from scipy.signal import fftconvolve

from cnnsim.support import Floats, InputError

EXTREMA_RATIO = 25 * np.sqrt(5) / 24
"""|u_zz(x = 0)| / |u_xz(x = z / 2)| on the line y = 0 under a normal load: eq. (18)."""
TERMS = 8
"""Skins that are no half-space differ by powers of t / (1 + t), this many less one at most."""
WIDTHS = 24
"""Depths, in samples, from which the fit may start."""
CLOSE = {"xtol": 1e-13, "ftol": 1e-13, "gtol": 1e-13}
FINE = {"xatol": 1e-10}
EXACT = 1e-20
"""Share of the energy of a scan below which what is left is rounding."""
LEAST = 11
"""Fewer samples than that are no scan."""
SURE = 5.0
"""beta_ns must be so many of its standard deviations large."""
BEYOND = 0.6
"""The scan must reach so many depths to either side of the taxel: the extrema of the shear are at half a depth."""


@dataclass(frozen=True)
class Sensitivity:
    """beta_ns and its standard deviation; negative where the shear is wired the other way round."""

    beta: float
    sigma: float


def beta_from_scan(shear: ArrayLike, normal: ArrayLike) -> Sensitivity:
    """Return beta_ns from a scan with a constant normal load along y = 0, right over the taxel.

        beta_ns = (|S_n|max / |T_x|max) / (25 sqrt(5) / 24)

    The maxima are those of smooth curves through all samples, so that noise is averaged and not sought out: with
    X = (x - x_0) / z, t = X^2 and p, q polynomials in t / (1 + t) of as few terms as the noise asks for,

        S_n = p / (1 + t)^(3/2),   T_x = 3 X q / (1 + t)^(5/2) + offset

    which is eq. (1) with p = 3 t / (1 + t) - 2 and eq. (10) with p = t / (1 + t) - 1, q constant. The sign is that of
    a scan toward growing x.

    Arguments: ``shear``, ``normal`` (n,) readings T_x, S_n at equally spaced places along the scan.

    Raises:
        InputError: shapes that differ, numbers that are not finite, a scan without all three extrema inside.

    Source: Vasarhelyi, Fodor, Roska, eqs (1), (18).
    """
    t, s = np.asarray(shear, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    if t.ndim != 1 or t.shape != s.shape:
        raise InputError(f"shear of shape {t.shape} and normal of shape {s.shape}, two equal (n,) wanted")
    if not (np.isfinite(t).all() and np.isfinite(s).all()):
        raise InputError("the scan has NaN or infinite readings, finite ones wanted")
    if not t.size or not t.any() or not s.any():
        raise InputError("the scan has no signal, one over a loaded taxel wanted")
    if t.size < LEAST:
        raise InputError(f"{t.size} samples, at least {LEAST} wanted")
    if not np.ptp(t):
        raise InputError(f"the shear is {t[0]:g} throughout the scan, one over a loaded taxel wanted")
    scan = np.array([s / np.abs(s).max(), t / np.ptp(t)])
    place, width = _start(scan)
    best, score = None, np.inf
    for terms in range(1, min(TERMS, (t.size - 3) // 2) + 1):
        start = _amplitudes(scan, place, width, terms)
        fit = least_squares(_rest, start, args=(scan,), method="lm", x_scale="jac", max_nfev=1000, **CLOSE)
        left = max(2 * fit.cost, EXACT * float((scan**2).sum()))
        bic = scan.size * np.log(left) + fit.x.size * np.log(scan.size)
        if best is not None and bic > score - 2:
            break
        best, score = fit, bic
        if left <= EXACT * float((scan**2).sum()):
            break
    assert best is not None
    middle, depth = best.x[:2]
    if middle < BEYOND * depth or middle > t.size - 1 - BEYOND * depth:
        raise InputError(
            f"the taxel lies at sample {middle:.1f} of {t.size} and is {depth:.1f} samples deep: the scan must go on"
            f" for {BEYOND:g} depths on either side, beyond every extremum"
        )
    unit = float(np.abs(s).max() / np.ptp(t))
    step = 1e-6 * np.maximum(np.abs(best.x), 1e-3)
    slope = [(_beta(best.x + h) - _beta(best.x - h)) / (2 * h.sum()) for h in np.diag(step)]
    variance = 2 * best.cost / max(scan.size - best.x.size, 1)
    spread = np.linalg.pinv(best.jac.T @ best.jac)
    beta, sigma = _beta(best.x), float(np.sqrt(variance * (slope @ spread @ slope)))
    if not abs(beta) > SURE * sigma:
        raise InputError(f"beta_ns {beta * unit:.3g} +- {sigma * unit:.3g}: the scan has no signal above its noise")
    return Sensitivity(beta * unit, sigma * unit)


def _curves(parameters: Floats, places: Floats) -> Floats:
    """Return S_n and T_x (2, n) at places in samples."""
    place, depth, offset, *rest = parameters
    half = (len(rest) + 1) // 2
    x = (places - place) / depth
    t = x * x
    normal, shear = (polynomial.polyval(t / (1 + t), each) for each in (rest[:half], rest[half:]))
    return np.array([normal * (1 + t) ** -1.5, 3 * x * shear * (1 + t) ** -2.5 + offset])


def _rest(parameters: Floats, scan: Floats) -> Floats:
    return np.asarray((_curves(parameters, np.arange(scan.shape[1], dtype=np.float64)) - scan).ravel())


def _amplitudes(scan: Floats, place: float, depth: float, terms: int) -> Floats:
    """Return the parameters with these two of which the others are best."""
    columns = np.eye(2 + 2 * terms)
    at = np.arange(scan.shape[1], dtype=np.float64)
    table = np.array([_curves(np.array([place, depth, *column]), at).ravel() for column in columns]).T
    return np.array([place, depth, *np.linalg.lstsq(table, scan.ravel(), rcond=None)[0]])


def _start(scan: Floats) -> tuple[float, float]:
    """Return the place and the depth, in samples, of the half-space that is nearest to the scan."""
    count = scan.shape[1]
    best = (np.inf, 0.0, 1.0)
    for depth in np.geomspace(0.5, count, WIDTHS):
        reach = np.arange(-count + 1, count) / depth
        shape = (reach**2 - 2) * (1 + reach**2) ** -2.5  # the stress has its peak there, too
        alike = np.abs(fftconvolve(scan[0], shape[::-1], mode="valid"))  # a direct one of a long scan takes seconds
        place = float(alike.argmax())
        left = float((_rest(_amplitudes(scan, place, depth, 1), scan) ** 2).sum())
        best = min(best, (left, place, float(depth)))
    return best[1:]


def _beta(parameters: Floats) -> float:
    """Return beta_ns of the fitted curves, as they are scaled."""
    _, _, _, *rest = parameters
    half = (len(rest) + 1) // 2
    swing = 1.5 * 1.25**-2.5 * rest[half]  # at half a depth
    if len(rest) > 3:
        local = np.array([0.0, 1.0, 0.0, *rest])
        top = minimize_scalar(
            lambda x: -abs(_curves(local, np.array([x]))[1, 0]), bounds=(0.1, 1.2), method="bounded", options=FINE
        )
        swing = _curves(local, np.array([top.x]))[1, 0]
    return float(abs(rest[0]) / swing / EXTREMA_RATIO)
